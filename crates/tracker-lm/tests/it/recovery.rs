//! Without noise, the truth comes back.

use nalgebra::{Point3, Vector3, Vector6};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tracker_lm::{
    AxisLetter, Calibration, DeadPath, ErrorOrder, Formulation, Gauge, Noise, Options, calibrate,
};

use crate::scene::{Plan, Scene, gaussian, rodrigues, simulate};

/// Displacement: 2⁻⁵² of a metre is 2e-13 mm, some hundred ranges and a condition of a hundred.
const EXACT_MM: f64 = 1e-9;
/// Rotation: the same over an arm of 200 mm.
const EXACT_RAD: f64 = 1e-12;

/// Exact data that start a millimetre off.
fn exact() -> Plan {
    Plan { noise_mm: 0.0, stations_off_mm: 0.0, mounts_off_mm: 1.0, ..Plan::default() }
}

/// Largest deviation of displacements (mm) and rotations (rad) from the truth.
fn deviation(found: &Calibration, scene: &Scene) -> (f64, f64) {
    let mut worst = (0.0_f64, 0.0_f64);
    for (found, truth) in found.axis_errors.iter().zip(&scene.errors) {
        let left = found.error - truth;
        worst.0 = worst.0.max(left.fixed_rows::<3>(0).amax());
        worst.1 = worst.1.max(left.fixed_rows::<3>(3).amax());
    }
    worst
}

fn options() -> Options {
    let noise = Noise { displacement_mm: Some(5e-4), ..Noise::default() };
    Options { noise, ..Options::default() }
}

#[test]
fn every_axis_and_dead_path_and_formulation() {
    for (n, letter) in [AxisLetter::A, AxisLetter::B, AxisLetter::C].into_iter().enumerate() {
        for dead_path in [DeadPath::Lock, DeadPath::Station] {
            for formulation in [Formulation::Joint, Formulation::FreePoints] {
                let plan = Plan { letter, per_lock: dead_path == DeadPath::Lock, ..exact() };
                let scene = simulate(&plan, 10 + n as u64);
                let options = Options { dead_path, formulation, ..options() };
                let found = calibrate(&scene.survey, &options).unwrap();
                let (mm, rad) = deviation(&found, &scene);
                assert!(
                    mm < EXACT_MM && rad < EXACT_RAD,
                    "{letter:?} {dead_path:?} {formulation:?}: {mm:e} mm {rad:e} rad"
                );
                assert!(found.residuals_mm.iter().all(|r| r.abs() < EXACT_MM));
            }
        }
    }
}

/// Moves nominal stations by about `off_mm` each, but not all of them together: their rigid fit
/// to the true ones stays the identity.
fn disturb_stations(scene: &mut Scene, off_mm: f64, rng: &mut ChaCha8Rng) {
    let n = scene.stations_mm.len();
    let mut moved: Vec<Vector3<f64>> = (0..n)
        .map(|i| scene.stations_mm[i] + Vector3::from_fn(|_, _| off_mm * gaussian(rng)))
        .collect();
    let mean = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / n as f64;
    // Each pass leaves the square of the angle of the one before.
    for _ in 0..6 {
        let shift = mean(&scene.stations_mm) - mean(&moved);
        for p in &mut moved {
            *p += shift;
        }
        let centre = mean(&moved);
        let (mut torque, mut inertia) = (Vector3::zeros(), nalgebra::Matrix3::zeros());
        for (p, truth) in moved.iter().zip(&scene.stations_mm) {
            let arm = p - centre;
            torque += arm.cross(&(truth - centre));
            inertia += nalgebra::Matrix3::identity() * arm.dot(&arm) - arm * arm.transpose();
        }
        let turn = inertia.try_inverse().unwrap() * torque;
        if turn.norm() == 0.0 {
            continue;
        }
        for p in &mut moved {
            *p = centre + rodrigues(&turn.normalize(), turn.norm()) * (*p - centre);
        }
    }
    for (station, at) in scene.survey.stations.iter_mut().zip(moved) {
        station.nominal_mm = Point3::from(at);
    }
}

#[test]
fn random_geometries_come_back_from_a_millimetre_off() {
    let mut rng = ChaCha8Rng::seed_from_u64(71);
    for seed in 0..200 {
        let plan = Plan {
            letter: [AxisLetter::A, AxisLetter::B, AxisLetter::C][rng.random_range(0..3)],
            stations: rng.random_range(5..=8),
            mounts: rng.random_range(3..=4),
            angles: rng.random_range(7..=15),
            half_arc_deg: rng.random_range(40.0..180.0),
            missing: [0.0, 0.05][rng.random_range(0..2)],
            ..exact()
        };
        let mut scene = simulate(&plan, 3000 + seed);
        disturb_stations(&mut scene, 1.0, &mut rng);
        let found = calibrate(&scene.survey, &options()).unwrap();
        let (mm, rad) = deviation(&found, &scene);
        assert!(mm < EXACT_MM && rad < EXACT_RAD, "{seed}: {mm:e} mm {rad:e} rad, {plan:?}");
    }
}

#[test]
fn poor_nominal_stations_are_replaced_by_the_ranges_own() {
    for seed in 0..4 {
        let plan = Plan { mounts_off_mm: 0.3, stations_off_mm: 100.0, ..exact() };
        let scene = simulate(&plan, 90 + seed);
        let found = calibrate(&scene.survey, &options()).unwrap();
        assert!(found.residuals_mm.iter().all(|r| r.abs() < EXACT_MM));
        // Where nominal positions are this poor the frame is theirs, but shapes are right.
        for i in 1..scene.stations_mm.len() {
            let truth = (scene.stations_mm[i] - scene.stations_mm[0]).norm();
            let apart = (found.stations[i].position_mm - found.stations[0].position_mm).norm();
            assert!((apart - truth).abs() < 1e-6, "{seed}: {apart} {truth}");
        }
    }
}

#[test]
fn every_gauge_sees_the_same_body() {
    let scene = simulate(&Plan { stations_off_mm: 0.05, ..Plan::default() }, 31);
    let all = [Gauge::Stations, Gauge::Minimal, Gauge::Inner]
        .map(|gauge| calibrate(&scene.survey, &Options { gauge, ..options() }).unwrap());
    for found in &all[1..] {
        // Residuals, dead paths and redundancy do not depend on the frame.
        for (a, b) in all[0].residuals_mm.iter().zip(&found.residuals_mm) {
            assert!((a - b).abs() < 1e-8);
        }
        for (a, b) in all[0].dead_paths.iter().zip(&found.dead_paths) {
            assert!((a.length_mm - b.length_mm).abs() < 1e-6);
            assert!((a.sigma_mm / b.sigma_mm - 1.0).abs() < 1e-6);
        }
        for (a, b) in all[0].redundancy.iter().zip(&found.redundancy) {
            assert!((a - b).abs() < 1e-6);
        }
    }
    // The minimal gauge holds the first station.
    let held = &all[1].stations[0];
    assert_eq!(held.position_mm, scene.survey.stations[0].nominal_mm);
    assert_eq!(held.covariance_mm2, nalgebra::Matrix3::zeros());
}

#[test]
fn rotating_errors_are_the_fixed_ones_turned_back() {
    let scene = simulate(&Plan::default(), 32);
    let fixed = calibrate(&scene.survey, &options()).unwrap();
    let order = ErrorOrder::Rotating;
    let rotating = calibrate(&scene.survey, &Options { order, ..options() }).unwrap();
    for (f, r) in fixed.axis_errors.iter().zip(&rotating.axis_errors) {
        let turned = rodrigues(&scene.survey.axis.direction, f.angle_rad);
        let mut expected = Vector6::zeros();
        for half in [0, 3] {
            let part = turned * r.error.fixed_rows::<3>(half);
            expected.fixed_rows_mut::<3>(half).copy_from(&part);
        }
        assert!((expected - f.error).amax() < 1e-12);
    }
}

#[test]
fn a_displaced_axis_shows_in_its_location() {
    let mut scene = simulate(&Plan { error_mm: 0.0, error_rad: 0.0, ..exact() }, 33);
    // The drawing is wrong by 10 µm along x: the errors are harmonics of that.
    scene.survey.axis.origin_mm.x -= 0.010;
    let found = calibrate(&scene.survey, &options()).unwrap();
    let location = found.location.unwrap();
    assert!((location.errors[0] - 0.010).abs() < 1e-6, "{}", location.errors);
    for error in &found.axis_errors {
        assert!((location.share(error.angle_rad) - error.error).amax() < 1e-6);
    }
}

#[test]
fn noise_that_is_not_declared_is_estimated() {
    let scene = simulate(&Plan::default(), 34);
    for formulation in [Formulation::Joint, Formulation::FreePoints] {
        let options = Options { formulation, ..Options::default() };
        let found = calibrate(&scene.survey, &options).unwrap();
        // 600 ranges, some 400 of them redundant: known to 4 %.
        assert!((found.displacement_mm / 5e-4 - 1.0).abs() < 0.12, "{}", found.displacement_mm);
    }
}

/// The noise is then that of rounding, and no step can be judged by it.
#[test]
fn exact_ranges_of_undeclared_noise_are_solved() {
    for seed in 0..24 {
        let plan = Plan { mounts: [3, 4][seed % 2], angles: 19, ..exact() };
        let scene = simulate(&plan, 300 + seed as u64);
        let found = calibrate(&scene.survey, &Options::default()).unwrap();
        let (displacement, rotation) = deviation(&found, &scene);
        assert!(displacement < EXACT_MM, "seed {seed}: {displacement:e} mm");
        assert!(rotation < EXACT_RAD, "seed {seed}: {rotation:e} rad");
    }
}

/// All six distances of four reflectors hold as much as a rigid body: of twelve coordinates at every
/// angle they leave six.
#[test]
fn distances_leave_as_much_free_as_a_rigid_body() {
    let scene = simulate(&Plan { angles: 9, ..Plan::default() }, 36);
    for formulation in [Formulation::Joint, Formulation::FreePoints] {
        let found = calibrate(&scene.survey, &Options { formulation, ..options() }).unwrap();
        // Stations less their frame, dead paths and reflectors; and the six errors of all angles but one.
        let unknowns = (3 * 6 - 6) + 6 * 4 + 3 * 4 + 6 * 8;
        assert_eq!(found.degrees_of_freedom, 9 * 6 * 4 - unknowns, "{formulation:?}");
    }
}

#[test]
fn redundancies_add_up_to_the_degrees_of_freedom() {
    let scene = simulate(&Plan { missing: 0.1, both_ways: true, ..Plan::default() }, 35);
    let found = calibrate(&scene.survey, &options()).unwrap();
    let sum: f64 = found.redundancy.iter().sum();
    assert!((sum - found.degrees_of_freedom as f64).abs() < 1e-6, "{sum}");
    let range = (0..found.redundancy.len())
        .min_by(|a, b| found.redundancy[*a].total_cmp(&found.redundancy[*b]))
        .unwrap();
    assert!(found.detectable_bias_mm(range) > 4.0 * 5e-4);
}
