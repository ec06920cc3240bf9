//! An axis that is declared perfect, and what it is missing.

use model_discrepancy::{Closure, State, Verdict, check_tangents, close_loop};
use nalgebra::{Vector3, Vector6};
use tracker_lm::{
    Approach, AxisModel, Formulation, Noise, Options, RotaryAxis, Survey, TrackerError,
    TrackerModel, calibrate,
};

use crate::scene::{Plan, Scene, rodrigues, simulate};

const NOISE_MM: f64 = 5e-4;
const STATION_MM: f64 = 4e-3;

fn options() -> Options {
    let noise =
        Noise { displacement_mm: Some(NOISE_MM), station_mm: Some(STATION_MM), ..Noise::default() };
    Options { axis: AxisModel::Fixed, noise, ..Options::default() }
}

/// An axis without errors.
fn perfect() -> Plan {
    Plan { error_mm: 0.0, error_rad: 0.0, angles: 19, ..Plan::default() }
}

fn closed(survey: Survey) -> (TrackerModel, Closure) {
    let mut model = TrackerModel::new(survey, None, Vec::new(), &options()).unwrap();
    let loop_options =
        model_discrepancy::Options { nested: false, max_steps: 12, ..Default::default() };
    let mut closure = close_loop(&model, &model.coordinates(), &loop_options).unwrap();
    while let Some(there) = model.about_found(&closure.solution()) {
        model = there;
        closure = close_loop(&model, &model.coordinates(), &loop_options).unwrap();
    }
    (model, closure)
}

/// Declares the axis elsewhere: it then stands `by_mm` and turned by `tilt` from its place.
fn declared_elsewhere(scene: &Scene, by_mm: Vector3<f64>, tilt: Vector3<f64>) -> Survey {
    let mut survey = scene.survey.clone();
    let RotaryAxis { letter, origin_mm, direction } = survey.axis;
    let back = rodrigues(&tilt.normalize(), -tilt.norm()) * direction.into_inner();
    survey.axis = RotaryAxis::new(letter, origin_mm - by_mm, back).unwrap();
    survey
}

/// Moves everything on the axis at every angle.
fn moved(scene: &Scene, error: impl Fn(f64) -> Vector6<f64>) -> Survey {
    let mut survey = scene.survey.clone();
    let axis = survey.axis;
    for range in &mut survey.ranges {
        let angle = survey.steps[range.step].angle_rad;
        let arm = rodrigues(&axis.direction, angle) * scene.mounts_mm[range.mount];
        let error = error(angle);
        let turn = error.fixed_rows::<3>(3).into_owned();
        let turned = match turn.norm() {
            0.0 => arm,
            length => rodrigues(&(turn / length), length) * arm,
        };
        let from = axis.origin_mm.coords - scene.stations_mm[range.station];
        let path = |arm: Vector3<f64>| (from + arm).norm();
        range.displacement_mm += path(turned + error.fixed_rows::<3>(0)) - path(arm);
    }
    survey
}

fn names(closure: &Closure) -> Vec<(&str, Option<&str>)> {
    closure.steps.iter().map(|s| (s.effect.as_str(), s.subject.as_deref())).collect()
}

#[test]
fn tangents_are_derivatives() {
    let plan = Plan { angles: 9, both_ways: true, missing: 0.05, ..perfect() };
    let survey = declared_elsewhere(
        &simulate(&plan, 4),
        Vector3::new(0.4, 0.0, 0.2),
        Vector3::new(3e-4, 0.0, 1e-4),
    );
    let model = TrackerModel::new(survey, None, Vec::new(), &options()).unwrap();
    // Rows are linear: central differences show rounding alone.
    assert!(check_tangents(&model, &State::start(&model)) < 1e-6);
}

#[test]
fn nothing_wrong_adds_nothing() {
    for both_ways in [false, true] {
        let (model, closure) = closed(simulate(&Plan { both_ways, ..perfect() }, 31).survey);
        assert!(closure.steps.is_empty(), "{:?}", closure.steps);
        assert_eq!(closure.verdict, Verdict::NothingMissing);
        let found = model.calibration_with(&closure).unwrap();
        assert!(found.location.is_none());
        assert!(found.axis_errors.iter().all(|e| e.error.norm() == 0.0));
    }
}

#[test]
fn a_missed_axis_is_named_with_its_place() {
    let (by, tilt) = (Vector3::new(0.53, 0.0, -0.2), Vector3::new(2e-4, 0.0, -4e-4));
    let scene = simulate(&perfect(), 32);
    let (model, closure) = closed(declared_elsewhere(&scene, by, tilt));
    assert_eq!(names(&closure), [("axis-location", None)]);
    assert_eq!(closure.verdict, Verdict::Explained);
    // Stations 4 µm off, dead paths and reflectors take most of it up.
    assert!(closure.before.held_out_rms > 5.0 * closure.after.held_out_rms);
    let found = model.calibration_with(&closure).unwrap();
    let location = found.location.as_ref().unwrap();
    let truth = [by.x, by.z, tilt.x, tilt.z];
    for (c, truth) in truth.into_iter().enumerate() {
        let std = location.covariance[(c, c)].sqrt();
        assert!((location.errors[c] - truth).abs() < 4.0 * std, "{c}: {location:?}");
        // What stations known to 4 µm leave of a place, and of a tilt over half a metre.
        assert!(std < if c < 2 { STATION_MM } else { 20e-6 }, "{c}: {std}");
    }
    // The errors relative to the first angle are those that the moved axis makes.
    for error in &found.axis_errors {
        let away = error.error - location.share(error.angle_rad);
        assert!(away.fixed_rows::<3>(0).norm() < 1e-3 && away.fixed_rows::<3>(3).norm() < 1e-6);
    }
    assert!(found.motion.unwrap().iter().all(|e| e.error.norm() == 0.0));
}

/// Six free errors at every angle take a missed axis up.
#[test]
fn free_errors_hide_a_missed_axis() {
    let scene = simulate(&perfect(), 32);
    let tilt = Vector3::new(1e-9, 0.0, 0.0);
    let survey = declared_elsewhere(&scene, Vector3::new(0.53, 0.0, 0.0), tilt);
    let free = calibrate(&survey, &Options { axis: AxisModel::Free, ..options() }).unwrap();
    let fixed = calibrate(&survey, &options()).unwrap();
    assert!(free.variance_factor < 1.3, "{}", free.variance_factor);
    assert!(fixed.variance_factor > 100.0, "{}", fixed.variance_factor);
}

#[test]
fn motion_errors_are_named_with_their_curves() {
    let cases: [(usize, f64, f64, &str, &str); 4] = [
        (0, 6e-3, 2.0, "radial-motion", "EXB"),
        (1, 5e-3, 1.0, "axial-motion", "EYB"),
        (4, 30e-6, 1.0, "angular-positioning", "EBB"),
        (5, 40e-6, 3.0, "tilt-motion", "ECB"),
    ];
    for (component, size, order, effect, subject) in cases {
        let curve = |angle: f64| Vector6::ith(component, size * (order * angle + 0.6).cos());
        let scene = simulate(&perfect(), 33);
        let (model, closure) = closed(moved(&scene, curve));
        assert_eq!(names(&closure), [(effect, Some(subject))], "{:?}", closure.steps);
        assert_eq!(closure.verdict, Verdict::Explained);
        let found = model.calibration_with(&closure).unwrap();
        for error in found.motion.unwrap() {
            let away = error.error - curve(error.angle_rad);
            let sigmas = error.sigmas();
            // A constant is the place of the axis, which the stations' 4 µm take up.
            let frame = if component < 3 { STATION_MM } else { 10e-6 };
            assert!(away[component].abs() < 5.0 * sigmas[component] + frame, "{away} {sigmas}");
            assert!(sigmas[component] < size);
        }
    }
}

#[test]
fn a_place_and_a_motion_are_told_apart() {
    let mut scene = simulate(&Plan { both_ways: true, angles: 13, ..perfect() }, 35);
    scene.survey = moved(&scene, |angle| Vector6::ith(4, 30e-6 * angle.sin()));
    let (by, tilt) = (Vector3::new(0.0, 0.0, 0.3), Vector3::new(0.0, 0.0, 2e-4));
    let (_, closure) = closed(declared_elsewhere(&scene, by, tilt));
    let mut found = names(&closure);
    found.sort_unstable();
    assert_eq!(found, [("angular-positioning", Some("EBB")), ("axis-location", None)]);
}

/// A rest that changes from each angle to the next is named where every angle was met three times.
/// Met twice, the two stops of an angle say by one difference how far stops scatter there, and the
/// values stay without a name, as structure that is left.
#[test]
fn values_by_angle_need_three_visits() {
    const SIZE_RAD: f64 = 20e-6;
    let rest = |angle: f64| {
        // Angles of 18° from −90° on.
        let is_even = ((angle.to_degrees() + 90.0) / 36.0 + 0.25).fract() < 0.5;
        Vector6::ith(4, if is_even { SIZE_RAD } else { -SIZE_RAD })
    };
    for once_more in [false, true] {
        let plan = Plan { angles: 11, both_ways: true, once_more, ..perfect() };
        let (model, closure) = closed(moved(&simulate(&plan, 38), rest));
        if !once_more {
            assert!(closure.steps.is_empty(), "{:?}", closure.steps);
            assert_eq!(closure.verdict, Verdict::StructureRemains);
            continue;
        }
        assert_eq!(names(&closure), [("angular-positioning", Some("EBB angle by angle"))]);
        assert_eq!(closure.verdict, Verdict::Explained);
        let motion = model.calibration_with(&closure).unwrap().motion.unwrap();
        let mean = motion.iter().map(|e| rest(e.angle_rad)[4]).sum::<f64>() / motion.len() as f64;
        for error in &motion {
            let away = error.error[4] - (rest(error.angle_rad)[4] - mean);
            assert!(away.abs() < 5.0 * error.sigmas()[4], "{} {away}", error.angle_rad);
        }
    }
}

#[test]
fn from_one_side_a_backlash_is_the_place_of_the_axis() {
    let model =
        TrackerModel::new(simulate(&perfect(), 36).survey, None, Vec::new(), &options()).unwrap();
    let closure =
        close_loop(&model, &model.coordinates(), &model_discrepancy::Options::default()).unwrap();
    assert!(closure.not_observable.iter().any(|n| n.effect == "backlash"));
    let steps = model.calibration().axis_errors.len();
    assert_eq!(steps, 19);
    assert!(
        simulate(&perfect(), 36)
            .survey
            .steps
            .iter()
            .all(|s| s.approach != Some(Approach::Negative))
    );
}

#[test]
fn free_points_have_no_perfect_axis() {
    let options = Options { formulation: Formulation::FreePoints, ..options() };
    let refused = calibrate(&simulate(&perfect(), 37).survey, &options);
    assert_eq!(refused.unwrap_err(), TrackerError::PerfectAxisOfFreePoints);
}
