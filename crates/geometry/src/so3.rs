//! Rotations: exp, log and their Jacobians.
//!
//! A rotation vector is axis times angle in rad. Perturbation on the left:
//! `exp(φ + δ) ≈ exp(J_l(φ) δ) exp(φ)`. Sources: Barfoot, *State Estimation for Robotics*
//! (2017), ch. 7; Solà, Deray, Atchuthan (2018), arXiv:1812.01537.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use crate::coefficients::{cosc, inverse_remainder, sinc, sinc_remainder};

/// Rotation by `|φ|` about `φ`.
///
/// Accurate to round-off for every angle; angles over π wrap.
#[must_use]
pub fn exp(rotation_rad: &Vector3<f64>) -> UnitQuaternion<f64> {
    let half = 0.5 * rotation_rad.norm();
    let vector = rotation_rad * (0.5 * sinc(half));
    UnitQuaternion::new_unchecked(Quaternion::from_parts(half.cos(), vector))
}

/// Rotation vector of a rotation, of length 0 to π.
///
/// The inverse of [`exp`]. At π, where `φ` and `−φ` are the same rotation, the sign is that of
/// the quaternion's vector part.
#[must_use]
pub fn log(rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    let sign = if rotation.w < 0.0 { -1.0 } else { 1.0 };
    let vector = sign * rotation.imag();
    let cos = sign * rotation.w;
    let sin = vector.norm();
    if sin == 0.0 { 2.0 * vector } else { vector * (2.0 * sin.atan2(cos) / sin) }
}

/// `J_l(φ)`: turns a change of the rotation vector into a rotation on the left.
///
/// `I + (1 − cos θ)/θ² [φ]× + (θ − sin θ)/θ³ [φ]×²`.
#[must_use]
pub fn left_jacobian(rotation_rad: &Vector3<f64>) -> Matrix3<f64> {
    let angle = rotation_rad.norm();
    let cross = rotation_rad.cross_matrix();
    Matrix3::identity() + cross * cosc(angle) + cross * cross * sinc_remainder(angle)
}

/// `J_l(φ)⁻¹`: turns a small rotation on the left into a change of the rotation vector.
///
/// `I − ½ [φ]× + (1 − (θ/2) cot(θ/2))/θ² [φ]×²`; singular at θ = 2π.
#[must_use]
pub fn left_jacobian_inverse(rotation_rad: &Vector3<f64>) -> Matrix3<f64> {
    let cross = rotation_rad.cross_matrix();
    Matrix3::identity() - cross * 0.5 + cross * cross * inverse_remainder(rotation_rad.norm())
}

/// `J_r(φ) = J_l(−φ) = J_l(φ)ᵀ`: the same for a rotation on the right.
#[must_use]
pub fn right_jacobian(rotation_rad: &Vector3<f64>) -> Matrix3<f64> {
    left_jacobian(&-rotation_rad)
}

/// `J_r(φ)⁻¹ = J_l(−φ)⁻¹`.
#[must_use]
pub fn right_jacobian_inverse(rotation_rad: &Vector3<f64>) -> Matrix3<f64> {
    left_jacobian_inverse(&-rotation_rad)
}
