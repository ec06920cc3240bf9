//! The first-order map of document [B] against the rotation itself.

use geometry::so3;
use nalgebra::{Matrix6, Point3, Vector3, Vector6};
use tracker_lm::{
    AxisError, AxisLetter, ErrorOrder, PointError, RotaryAxis, error_map, point_errors,
    point_errors_csv,
};

fn axis() -> RotaryAxis {
    let direction = Vector3::new(0.02, 1.0, -0.01);
    RotaryAxis::new(AxisLetter::B, Point3::new(100.0, -20.0, 300.0), direction).unwrap()
}

/// Errors of a bad axis at an angle: 30 µm and some 100 µrad.
fn error(k: u32) -> AxisError {
    let at = |i: u32| (1.7 * f64::from(7 * k + i) + 0.3).sin();
    let scale = |i: usize| if i < 3 { 0.03 } else { 1e-4 };
    let error = Vector6::from_fn(|i, _| scale(i) * at(u32::try_from(i).unwrap()));
    let factor = Matrix6::from_fn(|i, j| {
        let n = u32::try_from(6 * i + j).unwrap();
        0.05 * scale(i) * at(n)
    });
    AxisError { angle_rad: 0.4 * f64::from(k), error, covariance: factor * factor.transpose() }
}

const POINT_MM: Vector3<f64> = Vector3::new(40.0, 15.0, -250.0);

#[test]
fn the_map_leaves_what_it_says() {
    let axis = axis();
    let errors: Vec<AxisError> = (0..12).map(error).collect();
    let found = point_errors(&axis, ErrorOrder::Fixed, &errors, &POINT_MM);
    let mut largest = 0.0_f64;
    for (point, error) in found.iter().zip(&errors) {
        let arm = axis.rotation(error.angle_rad) * POINT_MM;
        let [shift, turn] = [0, 3].map(|first| error.error.fixed_rows::<3>(first).into_owned());
        let exact = axis.origin_mm + shift + so3::exp(&turn) * arm - (axis.origin_mm + arm);
        // Places of 500 mm: 250 · 2⁻⁵² · 10 operations.
        assert!((point.exact_mm - exact).norm() < 1e-12, "{point:?} {exact}");
        let left = (point.exact_mm - point.displacement_mm).norm();
        assert!(left <= 0.5 * turn.norm_squared() * arm.norm() * (1.0 + 1e-6), "{left}");
        largest = largest.max(left / (turn.norm_squared() * arm.norm()));
        assert!((point.displacement_mm - (shift + turn.cross(&arm))).norm() < 1e-15);
        assert_eq!(
            point.covariance_mm2,
            error_map(&arm) * error.covariance * error_map(&arm).transpose()
        );
    }
    // The bound is not idle.
    assert!(largest > 0.25, "{largest}");
}

#[test]
fn the_map_is_the_derivative() {
    let arm = Vector3::new(30.0, -120.0, 75.0);
    let map = error_map(&arm);
    for i in 0..6 {
        // Exact in the shifts; rotations to the third order of the step: 1e-12 · 150 mm.
        let moved = |d: f64| {
            let error = Vector6::ith(i, d);
            let of = AxisError { angle_rad: 0.0, error, covariance: Matrix6::zeros() };
            PointError::of(&of, arm).exact_mm
        };
        let h = 1e-4;
        let slope = (moved(h) - moved(-h)) / (2.0 * h);
        assert!((slope - map.column(i)).norm() < 1e-6, "{i}: {slope} {map}");
    }
    // Document [B]: B = [0 qz −qy 1 0 0; …] of (EA, EB, EC, EX, EY, EZ).
    assert_eq!(map.row(0).iter().copied().collect::<Vec<f64>>(), [1.0, 0.0, 0.0, 0.0, 75.0, 120.0]);
}

#[test]
fn errors_of_the_rotating_frame_move_the_point_alike() {
    let axis = axis();
    let fixed = error(5);
    let rotation = axis.rotation(fixed.angle_rad).to_rotation_matrix().into_inner();
    let mut back = Matrix6::zeros();
    back.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation.transpose());
    back.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation.transpose());
    let rotating = AxisError {
        angle_rad: fixed.angle_rad,
        error: back * fixed.error,
        covariance: back * fixed.covariance * back.transpose(),
    };
    let by_fixed = point_errors(&axis, ErrorOrder::Fixed, &[fixed], &POINT_MM)[0];
    let by_rotating = point_errors(&axis, ErrorOrder::Rotating, &[rotating], &POINT_MM)[0];
    assert!((by_fixed.displacement_mm - by_rotating.displacement_mm).norm() < 1e-15);
    assert!((by_fixed.covariance_mm2 - by_rotating.covariance_mm2).norm() < 1e-15);
}

#[test]
fn the_table_is_ascending_and_complete() {
    let errors: Vec<AxisError> = (0..3).rev().map(error).collect();
    let found = point_errors(&axis(), ErrorOrder::Fixed, &errors, &POINT_MM);
    let text = point_errors_csv(AxisLetter::B, &found);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 5);
    assert_eq!(lines[1].split(',').count(), 13);
    let row: Vec<f64> = lines[2].split(',').map(|cell| cell.parse().unwrap()).collect();
    assert_eq!(row.len(), 13);
    assert!(row[0].abs() < 1e-12);
    assert!((row[4] - found[2].displacement_mm.x).abs() < 1e-9 * found[2].displacement_mm.norm());
    assert!((row[7] - found[2].sigmas_mm().x).abs() < 1e-9 * found[2].sigmas_mm().norm());
    // Without errors nothing moves.
    let still = AxisError { angle_rad: 0.0, error: Vector6::zeros(), covariance: Matrix6::zeros() };
    let none = PointError::of(&still, POINT_MM);
    assert_eq!((none.displacement_mm, none.exact_mm), (Vector3::zeros(), Vector3::zeros()));
}
