//! Trackers that give points.

use model_discrepancy::{
    Closure, Covariate, Model, Options as LoopOptions, Quantity, State, Verdict, close_loop,
};
use nalgebra::{Matrix3, Point3, Rotation3, Vector3, Vector6};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tracker_lm::{
    Approach, AxisLetter, AxisModel, HoldOut, Mount, RotaryAxis, Station, Step, Target,
    TargetModel, TargetNoise, TargetOptions, TargetRecords, TargetSurvey, TrackerError,
    calibrate_targets,
};

use crate::scene::{gaussian, rodrigues};

/// 4 m · 2⁻⁵², some hundred readings and a condition of ten.
const EXACT_MM: f64 = 1e-9;
/// The same over an arm of 1 m.
const EXACT_RAD: f64 = 1e-12;

const RANGE_MM: f64 = 0.01;
const ANGLE_RAD: f64 = 5e-6;

/// What to simulate.
#[derive(Clone, Copy)]
struct Plan {
    stations: usize,
    angles: usize,
    both_ways: bool,
    noise: f64,
    /// Size of the errors of the axis, of 50 µm and 30 µrad.
    errors: f64,
    /// Difference between the two ways, mm along x and rad about z.
    backlash: (f64, f64),
    /// Mounts from the fourth on sag by this along −z times the cosine of the angle, mm.
    sag_mm: f64,
    /// One reading that is off by this along x, mm.
    slip_mm: f64,
}

const PLAN: Plan = Plan {
    stations: 1,
    angles: 11,
    both_ways: true,
    noise: 1.0,
    errors: 1.0,
    backlash: (0.0, 0.0),
    sag_mm: 0.0,
    slip_mm: 0.0,
};

const MOUNTS_MM: [[f64; 3]; 6] = [
    [1200.0, -900.0, 300.0],
    [-1100.0, -850.0, 500.0],
    [300.0, -700.0, -1300.0],
    [900.0, 800.0, 700.0],
    [-1000.0, 900.0, -400.0],
    [200.0, 850.0, 1250.0],
];
const STATIONS_MM: [[f64; 3]; 3] =
    [[200.0, -4000.0, -900.0], [3500.0, 2500.0, -700.0], [-3800.0, 1500.0, -500.0]];

struct Scene {
    survey: TargetSurvey,
    errors: Vec<Vector6<f64>>,
}

fn simulate(plan: &Plan, seed: u64) -> Scene {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let axis = Vector3::new(1e-3 * gaussian(&mut rng), 1.0, 1e-3 * gaussian(&mut rng)).normalize();
    let origin = Vector3::new(50.0, -30.0, 20.0);
    let mounts = MOUNTS_MM.map(Vector3::from);
    let up: Vec<f64> = (0..plan.angles).map(|k| -0.9 + 0.18 * k as f64).collect();
    let mut steps: Vec<(f64, bool)> = up.iter().map(|a| (*a, true)).collect();
    if plan.both_ways {
        steps.extend(up.iter().rev().skip(1).map(|a| (*a, false)));
    }
    let errors: Vec<Vector6<f64>> = (0..plan.angles)
        .map(|k| match k {
            0 => Vector6::zeros(),
            _ => Vector6::from_fn(|c, _| {
                plan.errors * gaussian(&mut rng) * if c < 3 { 0.05 } else { 30e-6 }
            }),
        })
        .collect();
    let poses: Vec<(Vector3<f64>, Matrix3<f64>)> = STATIONS_MM[..plan.stations]
        .iter()
        .map(|c| {
            let turn = Rotation3::new(Vector3::from_fn(|_, _| rng.random_range(-1.5..1.5)));
            (Vector3::from(*c), turn.into_inner())
        })
        .collect();
    let mut targets = Vec::new();
    for (step, (angle, rising)) in steps.iter().enumerate() {
        let k = up.iter().position(|a| a.total_cmp(angle).is_eq()).unwrap();
        for (mount, body) in mounts.iter().enumerate() {
            let way = if *rising { 0.5 } else { -0.5 };
            let mut body = *body;
            if mount >= 3 {
                body -= Vector3::z() * plan.sag_mm * (angle.cos() - up[0].cos());
            }
            if mount == 1 && step >= 7 {
                body.x += plan.slip_mm;
            }
            let mut error = errors[k];
            error[0] += way * plan.backlash.0;
            error[5] += way * plan.backlash.1;
            let turn = error.fixed_rows::<3>(3).into_owned();
            let mut arm = rodrigues(&axis, *angle) * body;
            if turn.norm() > 0.0 {
                arm = rodrigues(&turn.normalize(), turn.norm()) * arm;
            }
            let at = origin + error.fixed_rows::<3>(0) + arm;
            for (station, (center, turn)) in poses.iter().enumerate() {
                let sound = turn.transpose() * (at - center);
                let length = sound.norm();
                let beam = sound / length;
                let across = beam.cross(&Vector3::x()).normalize();
                let noise = beam * (RANGE_MM * gaussian(&mut rng))
                    + across * (ANGLE_RAD * length * gaussian(&mut rng))
                    + beam.cross(&across) * (ANGLE_RAD * length * gaussian(&mut rng));
                let at_mm = Point3::from(sound + noise * plan.noise);
                targets.push(Target { station, mount, step, at_mm });
            }
        }
    }
    let named = |n: usize| format!("{n}");
    let survey = TargetSurvey {
        axis: RotaryAxis::new(AxisLetter::B, Point3::from(origin), axis).unwrap(),
        stations: (0..plan.stations)
            .map(|i| Station { name: named(i), nominal_mm: Point3::origin() })
            .collect(),
        mounts: (mounts.iter().enumerate())
            .map(|(j, m)| Mount { name: named(j), nominal_mm: Point3::from(*m) })
            .collect(),
        steps: (steps.iter().enumerate())
            .map(|(k, (angle, rising))| Step {
                name: named(k),
                angle_rad: *angle,
                approach: Some(if *rising { Approach::Positive } else { Approach::Negative }),
            })
            .collect(),
        targets,
    };
    Scene { survey, errors }
}

fn polar() -> TargetOptions {
    let noise = TargetNoise::Polar { range_mm: RANGE_MM, angle_rad: ANGLE_RAD };
    TargetOptions { noise, ..TargetOptions::default() }
}

/// Moves the nominal mounts, but not all of them together.
fn disturb(survey: &mut TargetSurvey, off_mm: f64, rng: &mut ChaCha8Rng) {
    // A stretch and shears of the body: their rigid fit to the true places is the identity up to
    // the square of their size.
    let mut stretch = Matrix3::from_fn(|_, _| off_mm / 2e3 * gaussian(rng));
    let centre = survey.mounts.iter().map(|m| m.nominal_mm.coords).sum::<Vector3<f64>>() / 6.0;
    let scatter: Matrix3<f64> = (survey.mounts.iter())
        .map(|m| (m.nominal_mm.coords - centre) * (m.nominal_mm.coords - centre).transpose())
        .sum();
    // S·C symmetric: no net rotation.
    stretch = (stretch + stretch.transpose()) * 0.5 * scatter.try_inverse().unwrap() * 1e6;
    for mount in &mut survey.mounts {
        mount.nominal_mm += stretch * (mount.nominal_mm.coords - centre);
    }
}

#[test]
fn exact_points_give_back_the_errors() {
    for stations in 1..=3 {
        for options in [polar(), TargetOptions::default()] {
            let scene = simulate(&Plan { stations, noise: 0.0, ..PLAN }, 5);
            let found = calibrate_targets(&scene.survey, &options).unwrap();
            for (found, truth) in found.axis_errors.iter().zip(&scene.errors) {
                let left = found.error - truth;
                assert!(left.fixed_rows::<3>(0).amax() < EXACT_MM, "{left}");
                assert!(left.fixed_rows::<3>(3).amax() < EXACT_RAD, "{left}");
            }
            for (found, truth) in found.stations.iter().zip(STATIONS_MM) {
                let at = found.machine_from_station.translation.vector;
                assert!((at - Vector3::from(truth)).amax() < EXACT_MM);
            }
        }
    }
}

/// The nominal body need not be right: only its fit to the true one says where the machine is.
#[test]
fn nominal_places_only_hold_the_frame() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut scene = simulate(&Plan { stations: 2, noise: 0.0, ..PLAN }, 6);
    disturb(&mut scene.survey, 0.3, &mut rng);
    let found = calibrate_targets(&scene.survey, &polar()).unwrap();
    for (found, truth) in found.axis_errors.iter().zip(&scene.errors) {
        let left = found.error - truth;
        // The frame is off by the square of 0.3 mm over the body, 1e-7 mm, and turns errors.
        assert!(left.fixed_rows::<3>(0).amax() < 1e-5, "{left}");
        assert!(left.fixed_rows::<3>(3).amax() < 1e-8, "{left}");
    }
    assert!(found.rms_mm() < EXACT_MM);
}

/// Mean normalised square of all errors, whose expectation is 1.
#[test]
fn covariances_predict_the_scatter() {
    const SEEDS: u32 = 60;
    let (mut nees, mut covered, mut all) = (0.0, 0_usize, 0_usize);
    for seed in 0..SEEDS {
        let scene = simulate(&Plan { stations: 2, angles: 7, ..PLAN }, 100 + u64::from(seed));
        let found = calibrate_targets(&scene.survey, &polar()).unwrap();
        for (found, truth) in found.axis_errors.iter().zip(&scene.errors).skip(1) {
            let left = found.error - truth;
            let weighed = found.covariance.cholesky().unwrap().solve(&left);
            nees += left.dot(&weighed) / 6.0 / 6.0 / f64::from(SEEDS);
            let shares = left.component_div(&found.sigmas());
            covered += shares.iter().filter(|share| share.abs() < 1.96).count();
            all += 6;
        }
    }
    // Errors of one run share the first angle and the frame: some 15 of 36 numbers are free.
    assert!((nees - 1.0).abs() < 4.0 * (2.0 / (15.0 * f64::from(SEEDS))).sqrt(), "{nees}");
    let share = covered as f64 / all as f64;
    assert!((0.92..0.98).contains(&share), "{share}");
}

fn closed(
    scene: &Scene,
    hold_out: HoldOut,
    bodies: &[&str],
    options: &TargetOptions,
) -> (TargetModel, Closure) {
    let bodies = bodies.iter().map(|b| (*b).to_owned()).collect();
    let records = TargetRecords { bodies, ..TargetRecords::default() };
    let model = TargetModel::new(scene.survey.clone(), &records, hold_out, options).unwrap();
    let covariates = model.coordinates();
    let closure =
        close_loop(&model, &covariates, &LoopOptions { nested: false, ..Default::default() })
            .unwrap();
    (model, closure)
}

fn names(closure: &Closure) -> Vec<&str> {
    closure.steps.iter().map(|s| s.effect.as_str()).collect()
}

const TWO_BODIES: [&str; 6] = ["front", "front", "front", "rear", "rear", "rear"];

#[test]
fn nothing_wrong_adds_nothing() {
    let scene = simulate(&PLAN, 12);
    for hold_out in [HoldOut::Step, HoldOut::Mount] {
        let (_, closure) = closed(&scene, hold_out, &TWO_BODIES, &polar());
        assert_eq!(closure.verdict, Verdict::NothingMissing, "{:?}", names(&closure));
    }
}

#[test]
fn backlash_is_found_and_put_into_the_calibration() {
    let scene = simulate(&Plan { backlash: (0.05, 40e-6), ..PLAN }, 13);
    let (model, closure) = closed(&scene, HoldOut::Step, &[], &polar());
    assert_eq!(names(&closure), ["backlash"]);
    let effect = closure.steps[0].parameters.iter().find(|p| p.name == "EXB").unwrap();
    assert!((effect.value - 50.0).abs() < 4.0 * effect.std, "{effect:?}");
    let active: Vec<(usize, usize)> = (0..6).map(|p| (0, p)).collect();
    let (found, amplitudes) = model.calibration_with(&active).unwrap();
    assert!((amplitudes[5] - 40e-6).abs() < 5e-6, "{amplitudes:?}");
    assert!((found.variance_factor - 1.0).abs() < 0.3, "{}", found.variance_factor);
}

#[test]
fn a_second_body_is_found_by_its_label() {
    let scene = simulate(&Plan { sag_mm: 1.0, ..PLAN }, 14);
    let (_, closure) = closed(&scene, HoldOut::Step, &TWO_BODIES, &polar());
    assert_eq!(names(&closure), ["body-sag"]);
    assert_eq!(closure.steps[0].subject.as_deref(), Some("rear, cosine"));
    let of = |name: &str| closure.steps[0].parameters.iter().find(|p| p.name == name);
    let sag = of("z").unwrap();
    assert!((sag.value + 1000.0).abs() < 4.0 * sag.std, "{sag:?}");
    assert!(closure.after.held_out_rms < 0.7 * closure.before.held_out_rms);
}

/// A reflector is predicted from its first stop and the motion that the others show.
#[test]
fn reflectors_can_be_held_out() {
    for sag_mm in [0.0, 0.3] {
        let scene = simulate(&Plan { sag_mm, ..PLAN }, 17);
        let (_, closure) = closed(&scene, HoldOut::Mount, &TWO_BODIES, &polar());
        // 20 µm of noise, and the sag of three reflectors as the three others do not have it.
        let seen = closure.before.held_out_rms;
        let expected = if sag_mm > 0.0 { 0.036..0.2 } else { 0.015..0.05 };
        assert!(expected.contains(&seen), "{seen}");
        // Points shrunk to nothing have no residual: a scale must not be taken for that.
        let unseen: Vec<&str> = closure.not_observable.iter().map(|n| n.effect.as_str()).collect();
        assert!(unseen.contains(&"range-scale"), "{unseen:?}");
    }
}

#[test]
fn a_reflector_that_slips_is_found_where_it_slips() {
    let scene = simulate(&Plan { slip_mm: 0.2, ..PLAN }, 15);
    let (_, closure) = closed(&scene, HoldOut::Step, &[], &polar());
    assert_eq!(names(&closure), ["mount-slip"]);
    assert_eq!(closure.steps[0].subject.as_deref(), Some("1 at 7 from 0"));
}

/// Distances that read too long with the temperature of the air, as its column has it.
#[test]
fn a_scale_that_follows_the_air_is_named_by_its_column() {
    const PER_K: f64 = 5e-6;
    let mut scene = simulate(&PLAN, 18);
    let targets = &mut scene.survey.targets;
    let air_c: Vec<f64> =
        (0..targets.len()).map(|n| 20.0 + 2.0 * (0.05 * n as f64).sin()).collect();
    for (target, air_c) in targets.iter_mut().zip(&air_c) {
        target.at_mm.coords *= 1.0 + PER_K * (air_c - 20.0);
    }
    let air = Covariate::recorded("air_c", Quantity::Temperature, air_c);
    let records = TargetRecords { covariates: vec![air.clone()], ..TargetRecords::default() };
    let model = TargetModel::new(scene.survey, &records, HoldOut::Step, &polar()).unwrap();
    let covariates: Vec<Covariate> = model.coordinates().into_iter().chain([air]).collect();
    let options = LoopOptions { nested: false, ..Default::default() };
    let closure = close_loop(&model, &covariates, &options).unwrap();
    assert_eq!(names(&closure), ["temperature"]);
    assert_eq!(closure.steps[0].subject.as_deref(), Some("air_c"));
    let scale = &closure.steps[0].parameters[0];
    assert!((scale.value - 1e6 * PER_K).abs() < 4.0 * scale.std, "{scale:?}");
}

/// A tracker that was knocked stands elsewhere from its next reading on, by as much along whatever axes.
#[test]
fn a_tracker_that_was_knocked_is_named_from_its_next_reading_on() {
    let knocked = Vector3::new(0.2, -0.1, 0.2);
    let mut scene = simulate(&Plan { stations: 2, ..PLAN }, 19);
    for target in &mut scene.survey.targets {
        if target.station == 1 && target.step >= 12 {
            target.at_mm += knocked;
        }
    }
    let (_, closure) = closed(&scene, HoldOut::Step, &[], &polar());
    assert_eq!(names(&closure), ["station-shift"]);
    assert_eq!(closure.steps[0].subject.as_deref(), Some("1 from 0 at 12 on"));
    let moved: Vec<_> = closure.steps[0].parameters.iter().take(3).collect();
    let size = moved.iter().map(|p| p.value.powi(2)).sum::<f64>().sqrt();
    let std = moved.iter().map(|p| p.std).fold(0.0, f64::max);
    assert!((size - 1e3 * knocked.norm()).abs() < 4.0 * std, "{size} {std}");
}

/// Reflectors that are on the axis otherwise than drawn, by 0.4 mm and 3e-4: the axis is missed, and exact
/// points have no residual where the model is about its place.
#[test]
fn about_a_missed_axis_exact_points_have_no_residual() {
    let mut scene = simulate(&Plan { noise: 0.0, errors: 0.0, ..PLAN }, 20);
    let turn = Rotation3::new(Vector3::new(3e-4, 0.0, -2e-4));
    for mount in &mut scene.survey.mounts {
        mount.nominal_mm = turn * mount.nominal_mm + Vector3::new(0.4, 0.0, -0.2);
    }
    let options = TargetOptions { axis: AxisModel::Fixed, ..polar() };
    let records = TargetRecords::default();
    let model = TargetModel::new(scene.survey, &records, HoldOut::Step, &options).unwrap();
    let effects = &model.declared().effects;
    let place = effects.iter().position(|effect| effect.id == "axis-location").unwrap();
    let active: Vec<(usize, usize)> = (0..4).map(|p| (place, p)).collect();
    let (found, amplitudes) = model.calibration_with(&active).unwrap();
    assert!(found.rms_mm() < EXACT_MM);
    let about = model.about_found(&active).unwrap();
    let mut at = State::start(&about);
    at.amplitudes[place].copy_from_slice(&amplitudes);
    assert!(about.residuals(&at).amax() < EXACT_MM, "{}", about.residuals(&at).amax());
    // Without what was found they have.
    assert!(about.residuals(&State::start(&about)).amax() > 0.1);
}

#[test]
fn surveys_that_cannot_be_used_say_why() {
    let refused = |survey: &TargetSurvey| calibrate_targets(survey, &polar()).unwrap_err();
    let sound = simulate(&PLAN, 16).survey;
    let cut = |mounts: usize| {
        let mut survey = sound.clone();
        survey.mounts.truncate(mounts);
        survey.targets.retain(|t| t.mount < mounts);
        survey
    };
    assert!(matches!(refused(&cut(2)), TrackerError::TooFewMounts { needed: 3, got: 2 }));
    let mut line = sound.clone();
    for (mount, x) in line.mounts.iter_mut().zip(1..) {
        mount.nominal_mm = Point3::new(100.0 * f64::from(x), 0.0, 0.0);
    }
    assert!(matches!(refused(&line), TrackerError::CollinearMounts { .. }));
    let mut twice = sound.clone();
    twice.targets.push(twice.targets[0]);
    assert!(matches!(refused(&twice), TrackerError::DuplicateRange { .. }));
    let mut elsewhere = sound.clone();
    elsewhere.targets[3].station = 7;
    assert!(matches!(refused(&elsewhere), TrackerError::UnknownIndex { index: 7, .. }));
    let mut unseen = sound.clone();
    unseen.targets.retain(|t| t.mount != 2);
    assert!(matches!(refused(&unseen), TrackerError::Unseen { .. }));
    let mut broken = sound.clone();
    broken.targets[5].at_mm.x = f64::NAN;
    assert!(matches!(refused(&broken), TrackerError::InvalidNumber { .. }));
    let mut few = sound.clone();
    few.targets.retain(|t| t.step == 0 || t.mount < 2);
    assert!(matches!(
        refused(&few),
        TrackerError::Unobservable { .. } | TrackerError::TooFewRanges { .. }
    ));
}
