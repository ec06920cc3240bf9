//! Rigid transforms: exp, log, adjoint and Jacobians.
//!
//! Six-vectors are `[tx, ty, tz, rx, ry, rz]`, mm and rad. Perturbation on the left:
//! `T = exp(ξ) T̂`. Sources: Barfoot, *State Estimation for Robotics* (2017), ch. 7 (eq. 7.86 for
//! the coupling block); Solà, Deray, Atchuthan (2018), arXiv:1812.01537.

use nalgebra::{Isometry3, Matrix3, Matrix3x6, Matrix6, Point3, Translation3, Vector3, Vector6};

use crate::coefficients::{
    cosc, cosc_remainder, inverse_remainder, quintic_remainder, sinc_remainder,
};
use crate::so3;

/// Rigid transform of a constant twist over unit time.
#[must_use]
pub fn exp(twist: &Vector6<f64>) -> Isometry3<f64> {
    let (translation, rotation) = split(twist);
    let angle = rotation.norm();
    let once = rotation.cross(&translation);
    let twice = rotation.cross(&once);
    let moved = translation + once * cosc(angle) + twice * sinc_remainder(angle);
    Isometry3::from_parts(Translation3::from(moved), so3::exp(&rotation))
}

/// Twist of a rigid transform, of rotation 0 to π; the inverse of [`exp`].
#[must_use]
pub fn log(target_from_source: &Isometry3<f64>) -> Vector6<f64> {
    let rotation = so3::log(&target_from_source.rotation);
    let moved = target_from_source.translation.vector;
    let once = rotation.cross(&moved);
    let twice = rotation.cross(&once);
    join(&(moved - once * 0.5 + twice * inverse_remainder(rotation.norm())), &rotation)
}

/// `exp(ξ) T̂`, with the quaternion's length restored.
#[must_use]
pub fn retract(target_from_source: &Isometry3<f64>, twist: &Vector6<f64>) -> Isometry3<f64> {
    let mut moved = exp(twist) * target_from_source;
    moved.rotation.renormalize_fast();
    moved
}

/// `log(T T̂⁻¹)`: the twist that [`retract`] needs to get from `reference` to `target_from_source`.
///
/// `target_from_source` and `reference` map the same source frame to the same target frame.
#[must_use]
pub fn difference(target_from_source: &Isometry3<f64>, reference: &Isometry3<f64>) -> Vector6<f64> {
    log(&(target_from_source * reference.inverse()))
}

/// `Ad(T)`, `6 × 6`: `T exp(ξ) T⁻¹ = exp(Ad(T) ξ)`.
///
/// `[R, [t]× R; 0, R]`. Takes a twist, or an error of pose, from the source frame to the target frame.
#[must_use]
pub fn adjoint(target_from_source: &Isometry3<f64>) -> Matrix6<f64> {
    let rotation = target_from_source.rotation.to_rotation_matrix().into_inner();
    let coupling = target_from_source.translation.vector.cross_matrix() * rotation;
    upper_blocks(&rotation, &coupling)
}

/// `J_l(ξ)`, `6 × 6`: `exp(ξ + δ) ≈ exp(J_l(ξ) δ) exp(ξ)`.
#[must_use]
pub fn left_jacobian(twist: &Vector6<f64>) -> Matrix6<f64> {
    let (_, rotation) = split(twist);
    upper_blocks(&so3::left_jacobian(&rotation), &coupling_block(twist))
}

/// `J_l(ξ)⁻¹`; singular at a rotation of 2π.
#[must_use]
pub fn left_jacobian_inverse(twist: &Vector6<f64>) -> Matrix6<f64> {
    let (_, rotation) = split(twist);
    let inverse = so3::left_jacobian_inverse(&rotation);
    upper_blocks(&inverse, &-(inverse * coupling_block(twist) * inverse))
}

/// `J_r(ξ) = J_l(−ξ)`: `exp(ξ + δ) ≈ exp(ξ) exp(J_r(ξ) δ)`.
#[must_use]
pub fn right_jacobian(twist: &Vector6<f64>) -> Matrix6<f64> {
    left_jacobian(&-twist)
}

/// `J_r(ξ)⁻¹ = J_l(−ξ)⁻¹`.
#[must_use]
pub fn right_jacobian_inverse(twist: &Vector6<f64>) -> Matrix6<f64> {
    left_jacobian_inverse(&-twist)
}

/// `∂(exp(ξ) p)/∂ξ` at ξ = 0, `3 × 6`: `[I, −[p]×]`.
///
/// `point_mm` is in the target frame, that is, already moved.
#[must_use]
pub fn point_jacobian(point_mm: &Point3<f64>) -> Matrix3x6<f64> {
    let mut jacobian = Matrix3x6::zeros();
    jacobian.fixed_columns_mut::<3>(0).copy_from(&Matrix3::identity());
    jacobian.fixed_columns_mut::<3>(3).copy_from(&-point_mm.coords.cross_matrix());
    jacobian
}

/// Barfoot's `Q(ξ)`, eq. 7.86b.
fn coupling_block(twist: &Vector6<f64>) -> Matrix3<f64> {
    let (translation, rotation) = split(twist);
    let angle = rotation.norm();
    let r = rotation.cross_matrix();
    let t = translation.cross_matrix();
    let (rt, tr) = (r * t, t * r);
    let rtr = rt * r;
    let rrtr = r * rtr;
    t * 0.5
        + (rt + tr + rtr) * sinc_remainder(angle)
        + (r * rt + tr * r - rtr * 3.0) * cosc_remainder(angle)
        + (rtr * r + rrtr) * quintic_remainder(angle)
}

fn upper_blocks(diagonal: &Matrix3<f64>, coupling: &Matrix3<f64>) -> Matrix6<f64> {
    let mut out = Matrix6::zeros();
    out.fixed_view_mut::<3, 3>(0, 0).copy_from(diagonal);
    out.fixed_view_mut::<3, 3>(3, 3).copy_from(diagonal);
    out.fixed_view_mut::<3, 3>(0, 3).copy_from(coupling);
    out
}

fn split(twist: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (twist.fixed_rows::<3>(0).into_owned(), twist.fixed_rows::<3>(3).into_owned())
}

fn join(translation: &Vector3<f64>, rotation: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(translation.x, translation.y, translation.z, rotation.x, rotation.y, rotation.z)
}
