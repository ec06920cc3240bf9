//! Jacobians against differences of the functions they belong to.

use std::f64::consts::PI;

use geometry::nalgebra::{Matrix6, Point2, Point3, SVector, Vector2, Vector3, Vector6};
use geometry::{EulerAngles, se2, se3, so3};

use crate::regimes::{REACH_MM, rotations, twists};

/// Step of the fourth-order differences, rad; for translations, times `REACH_MM`.
const STEP: f64 = 1e-3;

/// Truncation h⁴/30 · |f⁗| ≈ 1e-13 and round-off ε/h ≈ 1e-12, times a few for products; with
/// lengths in units of `REACH_MM`.
const DIFFERENCE_TOL: f64 = 2e-11;

/// Derivative at zero by the five-point formula.
fn derivative<const N: usize>(f: impl Fn(f64) -> SVector<f64, N>) -> SVector<f64, N> {
    (8.0 * (f(STEP) - f(-STEP)) - (f(2.0 * STEP) - f(-2.0 * STEP))) / (12.0 * STEP)
}

/// Lengths in units of `REACH_MM`.
fn scaled(twist: &Vector6<f64>) -> Vector6<f64> {
    let mut out = *twist;
    out.fixed_rows_mut::<3>(0).scale_mut(1.0 / REACH_MM);
    out
}

fn unscaled(twist: &Vector6<f64>) -> Vector6<f64> {
    let mut out = *twist;
    out.fixed_rows_mut::<3>(0).scale_mut(REACH_MM);
    out
}

fn assert_columns(
    jacobian: &Matrix6<f64>,
    at: &Vector6<f64>,
    f: impl Fn(&Vector6<f64>) -> Vector6<f64>,
) {
    for k in 0..6 {
        let axis = unscaled(&Vector6::ith(k, 1.0));
        let expected = derivative(|t| scaled(&f(&(axis * t))));
        let error = (scaled(&(jacobian * axis)) - expected).amax();
        assert!(error < DIFFERENCE_TOL, "column {k} at {at:?}: {error}");
    }
}

/// Away from π by more than the differences reach, where log would wrap.
fn clear_of_pi(twist: &Vector6<f64>) -> bool {
    twist.fixed_rows::<3>(3).norm() < PI - 0.1
}

#[test]
fn left_and_right_jacobian() {
    for at in twists(21) {
        let pose = se3::exp(&at);
        assert_columns(&se3::left_jacobian(&at), &at, |d| {
            se3::log(&(se3::exp(&(at + d)) * pose.inverse()))
        });
        assert_columns(&se3::right_jacobian(&at), &at, |d| {
            se3::log(&(pose.inverse() * se3::exp(&(at + d))))
        });
    }
}

#[test]
fn inverse_jacobians() {
    for at in twists(22).iter().filter(|at| clear_of_pi(at)) {
        let pose = se3::exp(at);
        assert_columns(&se3::left_jacobian_inverse(at), at, |d| se3::log(&(se3::exp(d) * pose)));
        assert_columns(&se3::right_jacobian_inverse(at), at, |d| se3::log(&(pose * se3::exp(d))));
    }
}

#[test]
fn rotation_jacobians() {
    for at in rotations(23) {
        let there = so3::exp(&at);
        for k in 0..3 {
            let axis = Vector3::ith(k, 1.0);
            let left = derivative(|t| so3::log(&(so3::exp(&(at + axis * t)) * there.inverse())));
            let right = derivative(|t| so3::log(&(there.inverse() * so3::exp(&(at + axis * t)))));
            assert!((so3::left_jacobian(&at) * axis - left).amax() < DIFFERENCE_TOL);
            assert!((so3::right_jacobian(&at) * axis - right).amax() < DIFFERENCE_TOL);
            if at.norm() < PI - 0.1 {
                let left = derivative(|t| so3::log(&(so3::exp(&(axis * t)) * there)));
                let right = derivative(|t| so3::log(&(there * so3::exp(&(axis * t)))));
                assert!((so3::left_jacobian_inverse(&at) * axis - left).amax() < DIFFERENCE_TOL);
                assert!((so3::right_jacobian_inverse(&at) * axis - right).amax() < DIFFERENCE_TOL);
            }
        }
    }
}

#[test]
fn point_jacobians() {
    let point = Point3::new(300.0, -700.0, 500.0);
    let flat = Point2::new(300.0, -700.0);
    for k in 0..6 {
        let axis = unscaled(&Vector6::ith(k, 1.0));
        let expected: Vector3<f64> = derivative(|t| (se3::exp(&(axis * t)) * point).coords);
        let error = (se3::point_jacobian(&point) * axis - expected).amax();
        assert!(error < DIFFERENCE_TOL * REACH_MM, "column {k}: {error}");
    }
    for k in 0..3 {
        let axis = Vector3::ith(k, 1.0);
        let expected: Vector2<f64> = derivative(|t| (se2::exp(&(axis * t)) * flat).coords);
        let error = (se2::point_jacobian(&flat) * axis - expected).amax();
        assert!(error < DIFFERENCE_TOL * REACH_MM, "column {k}: {error}");
    }
}

#[test]
fn euler_jacobian() {
    for at in rotations(24) {
        let rotation = |d: Vector3<f64>| {
            let [alpha_rad, beta_rad, gamma_rad] = (at + d).into();
            EulerAngles { alpha_rad, beta_rad, gamma_rad }.to_rotation()
        };
        let [alpha_rad, beta_rad, gamma_rad] = at.into();
        let jacobian = EulerAngles { alpha_rad, beta_rad, gamma_rad }.left_jacobian();
        let there = rotation(Vector3::zeros());
        for k in 0..3 {
            let axis = Vector3::ith(k, 1.0);
            let expected = derivative(|t| so3::log(&(rotation(axis * t) * there.inverse())));
            assert!((jacobian * axis - expected).amax() < DIFFERENCE_TOL, "column {k} at {at:?}");
        }
    }
}
