//! Euler angles: both ways, the signs of [D], gimbal lock.

use std::f64::consts::{FRAC_PI_2, PI};

use geometry::nalgebra::{Matrix3, Vector3};
use geometry::{EulerAngles, EulerReading, so3};
use proptest::prelude::*;

use crate::regimes::{ROTATION_TOL_RAD, rotations};
use crate::seeded;

/// In gimbal lock, cos β < 1e-12, α is dropped: at most π · 1e-12.
const LOCKED_TOL_RAD: f64 = 4e-12;

fn elementary(axis: usize, angle: f64) -> Matrix3<f64> {
    let (s, c) = angle.sin_cos();
    match axis {
        0 => Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c),
        1 => Matrix3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c),
        _ => Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0),
    }
}

proptest! {
    #![proptest_config(seeded(512))]

    #[test]
    fn angles_come_back(alpha in -3.1..3.1, beta in -1.5..1.5, gamma in -3.1..3.1) {
        let angles = EulerAngles { alpha_rad: alpha, beta_rad: beta, gamma_rad: gamma };
        let rotation = angles.to_rotation();
        let expected = elementary(2, gamma) * elementary(1, beta) * elementary(0, alpha);
        let matrix = rotation.to_rotation_matrix().into_inner();
        prop_assert!((matrix - expected).abs().max() < ROTATION_TOL_RAD);

        let EulerReading::Unique(back) = EulerAngles::from_rotation(&rotation) else {
            panic!("no gimbal lock here");
        };
        // Round-off of the rotation over cos β.
        let tolerance = ROTATION_TOL_RAD / beta.cos();
        prop_assert!((back.alpha_rad - alpha).abs() < tolerance);
        prop_assert!((back.beta_rad - beta).abs() < ROTATION_TOL_RAD);
        prop_assert!((back.gamma_rad - gamma).abs() < tolerance);
    }
}

#[test]
fn every_rotation_is_put_together_again() {
    let mut all = rotations(31);
    // Up to and into gimbal lock from both sides.
    for k in 0..18 {
        for side in [-1.0, 1.0] {
            let angles = EulerAngles {
                alpha_rad: 0.7,
                beta_rad: side * (FRAC_PI_2 - 10.0_f64.powi(-k)),
                gamma_rad: -2.1,
            };
            all.push(so3::log(&angles.to_rotation()));
        }
    }
    for rotation in all {
        let there = so3::exp(&rotation);
        let reading = EulerAngles::from_rotation(&there);
        let back = reading.angles().to_rotation();
        let error = so3::log(&(back * there.inverse())).norm();
        let tolerance = match reading {
            EulerReading::Unique(_) => ROTATION_TOL_RAD,
            EulerReading::GimbalLock(_) => LOCKED_TOL_RAD,
        };
        assert!(error < tolerance, "{rotation:?}: {error}");
    }
}

#[test]
fn gimbal_lock_is_said() {
    for beta_rad in [FRAC_PI_2, -FRAC_PI_2] {
        let angles = EulerAngles { alpha_rad: 0.4, beta_rad, gamma_rad: 1.1 };
        let EulerReading::GimbalLock(read) = EulerAngles::from_rotation(&angles.to_rotation())
        else {
            panic!("β = {beta_rad} is gimbal lock");
        };
        assert!(read.alpha_rad == 0.0);
        // Only γ − α (β = π/2) or γ + α (β = −π/2) is determined.
        let expected = 1.1 - beta_rad.signum() * 0.4;
        assert!((read.gamma_rad - expected).abs() < ROTATION_TOL_RAD);
        assert!(angles.left_jacobian().determinant().abs() < ROTATION_TOL_RAD);
    }
}

#[test]
fn formulas_of_document_d() {
    let angles = EulerAngles { alpha_rad: 0.02, beta_rad: -0.03, gamma_rad: 0.5 };
    let r = angles.to_rotation().to_rotation_matrix();
    assert!((-r[(2, 0)].asin() - angles.beta_rad).abs() < ROTATION_TOL_RAD);
    assert!((r[(2, 1)].atan2(r[(2, 2)]) - angles.alpha_rad).abs() < ROTATION_TOL_RAD);
    assert!((r[(1, 0)].atan2(r[(0, 0)]) - angles.gamma_rad).abs() < ROTATION_TOL_RAD);
}

#[test]
fn small_angles_are_the_rotation_vector() {
    let angles = EulerAngles { alpha_rad: 3e-7, beta_rad: -2e-7, gamma_rad: 1e-7 };
    let rotation = so3::log(&angles.to_rotation());
    // Second order: 1e-7².
    assert!((rotation - Vector3::new(3e-7, -2e-7, 1e-7)).norm() < 1e-13);
    assert!(so3::log(&EulerAngles::default().to_rotation()).norm() < PI * f64::EPSILON);
}
