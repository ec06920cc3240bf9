//! Lie-group laws at the identity, at 1e-8, at random, across the switches of formula, near π.

use std::f64::consts::PI;

use geometry::nalgebra::{
    Isometry2, Isometry3, Matrix3, Matrix4, Matrix6, UnitQuaternion, Vector3, Vector6,
};
use geometry::{se2, se3, so3};

use crate::regimes::{ROTATION_TOL_RAD, TRANSLATION_TOL_MM, rotations, twists};

/// A rotation vector of length 1 at its last bits, after exp and log: 4 ε.
const LOG_EXP_TOL: f64 = 4.0 * f64::EPSILON;

/// Near π the two-fold sign of the axis needs `|φ| < π` by this, rad.
const WRAP_MARGIN_RAD: f64 = 1e-14;

fn assert_same_pose(a: &Isometry3<f64>, b: &Isometry3<f64>, what: &str) {
    let apart = a.inverse() * b;
    let angle = so3::log(&apart.rotation).norm();
    let distance = (a.translation.vector - b.translation.vector).norm();
    assert!(angle < ROTATION_TOL_RAD, "{what}: {angle} rad");
    assert!(distance < TRANSLATION_TOL_MM, "{what}: {distance} mm");
}

fn rotation_part(twist: &Vector6<f64>) -> Vector3<f64> {
    twist.fixed_rows::<3>(3).into_owned()
}

#[test]
fn log_undoes_exp_relative_to_the_angle() {
    for rotation in rotations(1) {
        let length = rotation.norm();
        if length > PI - WRAP_MARGIN_RAD {
            continue;
        }
        let error = (so3::log(&so3::exp(&rotation)) - rotation).norm();
        assert!(error <= LOG_EXP_TOL * length, "{rotation:?}: {error}");
    }
}

#[test]
fn log_of_a_negated_quaternion_is_the_same() {
    for rotation in rotations(2) {
        let there = so3::exp(&rotation);
        let negated = UnitQuaternion::new_unchecked(-there.into_inner());
        let error = (so3::log(&there) - so3::log(&negated)).norm();
        let half_turn = (so3::log(&there).norm() - PI).abs() < WRAP_MARGIN_RAD;
        assert!(error == 0.0 || half_turn, "{rotation:?}: {error}");
        assert!(so3::log(&there).norm() <= PI * (1.0 + f64::EPSILON));
    }
}

#[test]
fn log_keeps_the_axis_of_a_half_turn() {
    for axis in [Vector3::x(), Vector3::y(), Vector3::z(), Vector3::new(1.0, -2.0, 3.0)] {
        let axis = axis.normalize();
        let rotation = so3::log(&so3::exp(&(axis * PI)));
        assert!((rotation.norm() - PI).abs() <= ROTATION_TOL_RAD);
        assert!(rotation.cross(&axis).norm() <= ROTATION_TOL_RAD);
    }
}

#[test]
fn rotation_exp_is_rodrigues_matrix_exponential() {
    for rotation in rotations(3) {
        let expected = rotation.cross_matrix().exp();
        let error = (so3::exp(&rotation).to_rotation_matrix().into_inner() - expected).abs().max();
        assert!(error < ROTATION_TOL_RAD, "{rotation:?}: {error}");
    }
}

#[test]
fn rigid_exp_is_the_matrix_exponential() {
    for twist in twists(4) {
        // Lengths in m, so that the general algorithm's norm is not all translation.
        let mut generator = Matrix4::zeros();
        generator.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation_part(&twist).cross_matrix());
        generator.fixed_view_mut::<3, 1>(0, 3).copy_from(&(twist.fixed_rows::<3>(0) / 1000.0));
        let expected = generator.exp();
        let pose = se3::exp(&twist);
        let translation = expected.fixed_view::<3, 1>(0, 3) * 1000.0;
        let error = (pose.translation.vector - translation).norm();
        assert!(error < TRANSLATION_TOL_MM, "{twist:?}: {error} mm");
    }
}

#[test]
fn exp_undoes_log() {
    for twist in twists(5) {
        let pose = se3::exp(&twist);
        assert_same_pose(&se3::exp(&se3::log(&pose)), &pose, "exp log");
    }
}

#[test]
fn log_undoes_rigid_exp() {
    for twist in twists(6) {
        if rotation_part(&twist).norm() > PI - WRAP_MARGIN_RAD {
            continue;
        }
        let error = se3::log(&se3::exp(&twist)) - twist;
        let size = twist.fixed_rows::<3>(0).norm();
        // Inverting the Jacobian near π magnifies by π/2.
        assert!(error.fixed_rows::<3>(0).norm() <= 40.0 * f64::EPSILON * size, "{twist:?}");
        assert!(rotation_part(&error).norm() <= LOG_EXP_TOL * rotation_part(&twist).norm());
    }
}

#[test]
fn negation_inverts() {
    for twist in twists(7) {
        assert_same_pose(&se3::exp(&-twist), &se3::exp(&twist).inverse(), "exp(-ξ)");
    }
}

#[test]
fn parallel_twists_add() {
    for twist in twists(8) {
        let parts = se3::exp(&(twist * 0.25)) * se3::exp(&(twist * 0.75));
        assert_same_pose(&parts, &se3::exp(&twist), "exp(ξ/4) exp(3ξ/4)");
    }
}

#[test]
fn adjoint_carries_twists_between_frames() {
    let twists = twists(9);
    for (pose, twist) in twists.iter().zip(twists.iter().skip(7)) {
        let (pose, small) = (se3::exp(pose), twist * 1e-3);
        let carried = se3::exp(&(se3::adjoint(&pose) * small));
        assert_same_pose(&carried, &(pose * se3::exp(&small) * pose.inverse()), "adjoint");
    }
}

#[test]
fn adjoint_is_a_homomorphism() {
    let twists = twists(10);
    for (a, b) in twists.iter().zip(twists.iter().skip(5)) {
        let (a, b) = (se3::exp(a), se3::exp(b));
        let error = se3::adjoint(&(a * b)) - se3::adjoint(&a) * se3::adjoint(&b);
        assert!(error.fixed_view::<3, 3>(3, 3).abs().max() < ROTATION_TOL_RAD);
        assert!(error.abs().max() < TRANSLATION_TOL_MM);
    }
}

#[test]
fn retract_and_difference_are_inverse() {
    let twists = twists(11);
    for (a, b) in twists.iter().zip(twists.iter().skip(11)) {
        let (a, b) = (se3::exp(a), se3::exp(b));
        assert_same_pose(&se3::retract(&b, &se3::difference(&a, &b)), &a, "retract difference");
    }
}

#[test]
fn jacobians_and_their_inverses_multiply_to_one() {
    for twist in twists(12) {
        let left = se3::left_jacobian(&twist) * se3::left_jacobian_inverse(&twist);
        let right = se3::right_jacobian(&twist) * se3::right_jacobian_inverse(&twist);
        for product in [left, right] {
            let error = product - Matrix6::identity();
            assert!(error.fixed_view::<3, 3>(0, 0).abs().max() < ROTATION_TOL_RAD, "{twist:?}");
            assert!(error.abs().max() < TRANSLATION_TOL_MM, "{twist:?}");
        }
    }
}

#[test]
fn left_jacobian_is_adjoint_times_right() {
    for twist in twists(13) {
        let error = se3::left_jacobian(&twist)
            - se3::adjoint(&se3::exp(&twist)) * se3::right_jacobian(&twist);
        assert!(error.fixed_view::<3, 3>(0, 0).abs().max() < ROTATION_TOL_RAD, "{twist:?}");
        assert!(error.abs().max() < TRANSLATION_TOL_MM, "{twist:?}");
    }
}

#[test]
fn a_twist_is_fixed_by_its_own_jacobians() {
    for twist in twists(14) {
        for jacobian in [se3::left_jacobian(&twist), se3::right_jacobian_inverse(&twist)] {
            let error = jacobian * twist - twist;
            assert!(rotation_part(&error).norm() < ROTATION_TOL_RAD, "{twist:?}");
            assert!(error.norm() < TRANSLATION_TOL_MM * PI, "{twist:?}");
        }
    }
}

#[test]
fn planar_laws_follow_the_spatial_ones() {
    for twist in twists(15) {
        let angle = rotation_part(&twist).norm();
        for signed in [angle, -angle] {
            let flat = Vector3::new(twist.x, twist.y, signed);
            let spatial = Vector6::new(twist.x, twist.y, 0.0, 0.0, 0.0, signed);
            let rows = |m: &Matrix6<f64>| {
                let picks = [0, 1, 5];
                Matrix3::from_fn(|i, j| m[(picks[i], picks[j])])
            };
            let pose = se2::exp(&flat);
            let expected = se3::exp(&spatial);
            let apart = (pose.translation.vector - expected.translation.vector.xy()).norm();
            assert!(apart < TRANSLATION_TOL_MM);
            for (planar, spatial) in [
                (se2::adjoint(&pose), se3::adjoint(&expected)),
                (se2::left_jacobian(&flat), se3::left_jacobian(&spatial)),
                (se2::left_jacobian_inverse(&flat), se3::left_jacobian_inverse(&spatial)),
                (se2::right_jacobian(&flat), se3::right_jacobian(&spatial)),
                (se2::right_jacobian_inverse(&flat), se3::right_jacobian_inverse(&spatial)),
            ] {
                assert!((planar - rows(&spatial)).abs().max() < TRANSLATION_TOL_MM, "{flat:?}");
            }
        }
    }
}

#[test]
fn planar_log_and_exp_are_inverse() {
    for twist in twists(16) {
        let flat = Vector3::new(twist.x, twist.y, rotation_part(&twist).norm());
        let pose = se2::exp(&flat);
        let log = se2::log(&pose);
        assert!((log.xy() - flat.xy()).norm() < 2.0 * TRANSLATION_TOL_MM, "{flat:?}");
        assert!((log.z - flat.z).abs() <= LOG_EXP_TOL * flat.z, "{flat:?}");
        let reference = Isometry2::new(flat.yx(), 0.3 * flat.z);
        let back = se2::retract(&reference, &se2::difference(&pose, &reference));
        assert!((back.translation.vector - pose.translation.vector).norm() < TRANSLATION_TOL_MM);
        assert!(back.rotation.angle_to(&pose.rotation).abs() < ROTATION_TOL_RAD);
    }
}

#[test]
fn long_chains_of_retractions_stay_rotations() {
    let step = Vector6::new(0.1, -0.2, 0.3, 0.01, 0.02, -0.03);
    let pose = (0..100_000).fold(Isometry3::identity(), |pose, _| se3::retract(&pose, &step));
    assert!((pose.rotation.norm() - 1.0).abs() <= 2.0 * f64::EPSILON);
}
