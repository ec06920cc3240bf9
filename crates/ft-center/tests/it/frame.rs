//! Frame between machine and sensor: rigid, reflected, affine, degenerate.

use ft_center::{
    FramePoint, FtCenterError, Handedness, HandednessSource, fit_affine_frame, fit_sensor_frame,
};
use nalgebra::{Matrix2, Matrix3, Point2, Rotation2, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::simulator::{Placement, normal};

/// Round-off of a fit over 1 m: 1e3 mm · 2⁻⁵² · 50 operations.
const EXACT_TOL_MM: f64 = 1e-11;

fn point(machine_mm: Point2<f64>, sensor_mm: Point2<f64>) -> FramePoint {
    FramePoint { machine_mm, sensor_mm, covariance_mm2: Matrix2::identity() * 1e-4 }
}

fn placed(placement: &Placement, machine: &[[f64; 2]]) -> Vec<FramePoint> {
    machine.iter().map(|m| point((*m).into(), placement.to_sensor((*m).into()))).collect()
}

fn circle(radius_mm: f64) -> Vec<[f64; 2]> {
    (0..3)
        .map(|i| {
            let angle = f64::from(i) * std::f64::consts::TAU / 3.0;
            [radius_mm * angle.cos(), radius_mm * angle.sin()]
        })
        .collect()
}

#[test]
fn recovers_any_placement() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for round in 0..200 {
        let placement = Placement {
            angle_rad: rng.random_range(-3.1..3.1),
            mirrored: round % 2 == 1,
            shift_mm: Vector2::from_fn(|_, _| rng.random_range(-500.0..500.0)),
        };
        let machine: Vec<_> = (0..5)
            .map(|_| [rng.random_range(-500.0..500.0), rng.random_range(0.0..900.0)])
            .collect();
        let frame = fit_sensor_frame(&placed(&placement, &machine), None).unwrap();
        assert!((frame.angle_rad - placement.angle_rad).abs() < 1e-13);
        assert!((frame.translation_mm - placement.shift_mm).norm() < EXACT_TOL_MM);
        assert_eq!(frame.handedness == Handedness::Opposed, placement.mirrored);
        assert_eq!(frame.handedness_source, HandednessSource::Measured);
        assert_eq!(frame.degrees_of_freedom, 7);
        let round_trip = frame.machine_from_sensor() * frame.sensor_from_machine();
        assert!((round_trip.to_homogeneous() - Matrix3::identity()).norm() < EXACT_TOL_MM);
    }
}

#[test]
fn a_rotation_misses_a_mirrored_circle_by_its_radius_times_root_two() {
    let placement = Placement { angle_rad: 0.7, mirrored: true, shift_mm: Vector2::new(3.0, 4.0) };
    let points = placed(&placement, &circle(30.0));
    let frame = fit_sensor_frame(&points, None).unwrap();
    assert_eq!(frame.handedness, Handedness::Opposed);
    assert!((frame.other_handedness_rms_mm - 30.0 * 2f64.sqrt()).abs() < EXACT_TOL_MM);
    assert!((frame.other_handedness_rms_mm - 42.0).abs() < 0.5);

    let forced = fit_sensor_frame(&points, Some(Handedness::Same)).unwrap();
    assert_eq!(forced.handedness_source, HandednessSource::Given);
    let rms =
        (forced.residuals_mm.iter().map(nalgebra::Matrix::norm_squared).sum::<f64>() / 3.0).sqrt();
    assert!(rms > 42.0, "{rms} mm");
}

#[test]
fn two_points_give_a_frame_but_no_handedness() {
    let placement = Placement { angle_rad: 0.7, mirrored: true, shift_mm: Vector2::new(3.0, 4.0) };
    let points = placed(&placement, &[[0.0, 0.0], [40.0, 10.0]]);
    let frame = fit_sensor_frame(&points, None).unwrap();
    assert_eq!(frame.degrees_of_freedom, 1);
    assert_eq!(frame.handedness_source, HandednessSource::Assumed);
    assert!(frame.residuals_mm.iter().all(|r| r.norm() < EXACT_TOL_MM));
    let line = placed(&placement, &[[0.0, 0.0], [40.0, 10.0], [80.0, 20.0]]);
    let frame = fit_sensor_frame(&line, None).unwrap();
    assert_eq!(frame.handedness_source, HandednessSource::Assumed);
    let given = fit_sensor_frame(&points, Some(Handedness::Opposed)).unwrap();
    assert!((given.angle_rad - 0.7).abs() < 1e-13);
}

#[test]
fn noise_does_not_decide_the_handedness_of_a_line() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let placement = Placement { angle_rad: 0.7, mirrored: true, shift_mm: Vector2::new(3.0, 4.0) };
    let wrong = (0..500)
        .filter(|_| {
            let mut points = placed(&placement, &[[0.0, 0.0], [40.0, 10.0], [80.0, 20.0]]);
            for p in &mut points {
                p.sensor_mm += 0.01 * Vector2::new(normal(&mut rng), normal(&mut rng));
            }
            fit_sensor_frame(&points, None).unwrap().handedness_source == HandednessSource::Measured
        })
        .count();
    assert_eq!(wrong, 0);
}

#[test]
fn far_origins_cost_nothing_about_the_pivot() {
    let placement =
        Placement { angle_rad: 0.3, mirrored: false, shift_mm: Vector2::new(1e5, -1e5) };
    let machine = [[1e5, 1e5], [1e5 + 40.0, 1e5], [1e5, 1e5 + 40.0]];
    let frame = fit_sensor_frame(&placed(&placement, &machine), None).unwrap();
    // 1e5 mm · 2⁻⁵² · 50 operations, over a baseline of 40 mm.
    assert!((frame.angle_rad - 0.3).abs() < 3e-11);
    assert!(frame.residuals_mm.iter().all(|r| r.norm() < 1e-9));
    let std = frame.covariance.diagonal().map(f64::sqrt);
    assert!((std[1] - 0.01 / 3f64.sqrt()).abs() < 1e-6, "pivot {} mm", std[1]);
}

#[test]
fn covariances_weigh_the_points() {
    let placement = Placement { angle_rad: 0.0, mirrored: false, shift_mm: Vector2::zeros() };
    let mut points = placed(&placement, &[[0.0, 0.0], [100.0, 0.0], [0.0, 100.0], [100.0, 100.0]]);
    points[3].sensor_mm.x += 1.0;
    points[3].covariance_mm2 = Matrix2::new(1e4, 0.0, 0.0, 1e-4);
    let frame = fit_sensor_frame(&points, None).unwrap();
    // The bad coordinate weighs 1e-8 of the others.
    assert!(frame.residuals_mm[0].norm() < 1e-6);
    assert!((frame.residuals_mm[3].x - 1.0).abs() < 1e-6);
}

/// Angles of the grid that looks for a better one.
const GRID: u32 = 720;

#[test]
fn no_other_angle_is_better_whatever_the_points_and_their_covariances() {
    for seed in 0..200 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut any = |size: f64| normal(&mut rng) * size;
        let points: Vec<FramePoint> = (0..5)
            .map(|_| {
                // Positions that have nothing to do with each other, as from another session.
                let (machine_mm, sensor_mm) =
                    (Point2::new(any(30.0), any(30.0)), Point2::new(any(30.0), any(30.0)));
                let (turn, [a, b]) = (Rotation2::new(any(3.0)), [any(3.0).exp(), any(3.0).exp()]);
                let covariance_mm2 =
                    turn * Matrix2::from_diagonal(&Vector2::new(a, b)) * turn.inverse();
                FramePoint { machine_mm, sensor_mm, covariance_mm2 }
            })
            .collect();
        let cost = |angle_rad: f64| {
            let turned = |p: &FramePoint| {
                p.sensor_mm.coords - Rotation2::new(angle_rad) * p.machine_mm.coords
            };
            let weight = |p: &FramePoint| p.covariance_mm2.try_inverse().expect("definite");
            let total: Matrix2<f64> = points.iter().map(weight).sum();
            let mean = points.iter().map(|p| weight(p) * turned(p)).sum::<Vector2<f64>>();
            let mean = total.try_inverse().expect("definite") * mean;
            let miss = |p: &FramePoint| turned(p) - mean;
            points.iter().map(|p| miss(p).dot(&(weight(p) * miss(p)))).sum::<f64>()
        };
        let frame = match fit_sensor_frame(&points, Some(Handedness::Same)) {
            Ok(frame) => frame,
            Err(FtCenterError::AngleFree { .. }) => continue,
            Err(e) => panic!("seed {seed}: {e}"),
        };
        let found = cost(frame.angle_rad);
        for k in 0..GRID {
            let other = cost(std::f64::consts::TAU * f64::from(k) / f64::from(GRID));
            // The costs are sums of squares of whitened misses: they agree to round-off where they are one.
            assert!(
                found <= other * (1.0 + 1e-9),
                "seed {seed}: {found} at the answer, {other} at {k}"
            );
        }
    }
}

#[test]
fn three_points_reproduce_the_documents_matrix() {
    let points = [
        point([10.0, 20.0].into(), [-3.0, 8.0].into()),
        point([50.0, 25.0].into(), [36.0, 15.0].into()),
        point([30.0, 70.0].into(), [14.0, 57.0].into()),
    ];
    let columns = |of: fn(&FramePoint) -> Point2<f64>| {
        Matrix3::from_columns(&points.map(|p| Vector3::new(of(&p).x, of(&p).y, 1.0)))
    };
    let expected = columns(|p| p.sensor_mm) * columns(|p| p.machine_mm).try_inverse().unwrap();
    let affine = fit_affine_frame(&points).unwrap();
    let difference = affine.sensor_from_machine.to_homogeneous() - expected;
    assert!(difference.norm() < EXACT_TOL_MM);
    assert_eq!(affine.degrees_of_freedom, 0);
    assert!(affine.residuals_mm.iter().all(|r| r.norm() < EXACT_TOL_MM));
}

#[test]
fn the_affine_frame_shows_scale_and_shear() {
    let machine = [[0.0, 0.0], [100.0, 0.0], [0.0, 100.0], [90.0, 110.0]];
    let map = |m: &[f64; 2]| Point2::new(1.01 * m[0] - 0.004 * m[1], 0.99 * m[1]);
    let points: Vec<_> = machine.iter().map(|m| point((*m).into(), map(m))).collect();
    let affine = fit_affine_frame(&points).unwrap();
    let area = affine.scale_ratios[0] * affine.scale_ratios[1];
    assert!((area - 1.01 * 0.99).abs() < 1e-12);
    assert!(affine.scale_ratios[0] > 1.0099 && affine.scale_ratios[1] < 0.9901);
    // The image of y leans away from that of x by 0.004/0.99.
    assert!((affine.shear_rad - (0.004f64 / 0.99).atan()).abs() < 1e-12);
    assert!(affine.residuals_mm.iter().all(|r| r.norm() < EXACT_TOL_MM));
}

#[test]
fn what_is_not_determined_is_an_error() {
    let placement = Placement { angle_rad: 0.7, mirrored: false, shift_mm: Vector2::new(3.0, 4.0) };
    let one = placed(&placement, &[[0.0, 0.0]]);
    assert_eq!(
        fit_sensor_frame(&one, None).unwrap_err(),
        FtCenterError::TooFewFramePoints { got: 1, needed: 2 }
    );
    let same = placed(&placement, &[[5.0, 5.0], [5.0, 5.0], [5.0, 5.0]]);
    assert!(matches!(fit_sensor_frame(&same, None), Err(FtCenterError::CoincidentPoints { .. })));
    // 10 µm apart, each known to 10 µm: the angle is anybody's guess.
    let close = placed(&placement, &[[5.0, 5.0], [5.01, 5.0]]);
    assert!(matches!(fit_sensor_frame(&close, None), Err(FtCenterError::AngleFree { .. })));
    let line = placed(&placement, &[[0.0, 0.0], [40.0, 10.0], [80.0, 20.0]]);
    assert!(matches!(fit_affine_frame(&line), Err(FtCenterError::CollinearPoints { .. })));
    assert!(matches!(
        fit_affine_frame(&line[..2]),
        Err(FtCenterError::TooFewFramePoints { got: 2, needed: 3 })
    ));
    let mut bad = placed(&placement, &circle(30.0));
    bad[1].sensor_mm.y = f64::NAN;
    assert_eq!(fit_sensor_frame(&bad, None).unwrap_err(), FtCenterError::NotFinite { index: 1 });
    let mut bad = placed(&placement, &circle(30.0));
    bad[2].covariance_mm2 = Matrix2::zeros();
    assert_eq!(
        fit_sensor_frame(&bad, None).unwrap_err(),
        FtCenterError::InvalidCovariance { index: 2 }
    );
}
