//! Planar rigid transforms: exp, log, adjoint and Jacobians.
//!
//! Three-vectors are `[tx, ty, rz]`, mm and rad. Perturbation on the left: `T = exp(ξ) T̂`.
//! Source: Solà, Deray, Atchuthan (2018), arXiv:1812.01537. Maps with reflection, scale or shear are
//! [`PlanarMap`](crate::PlanarMap)s.

use nalgebra::{
    Isometry2, Matrix2, Matrix2x3, Matrix3, Point2, Translation2, UnitComplex, Vector2, Vector3,
};

use crate::coefficients::{cosc, half_cot, sinc, sinc_remainder};

/// Planar rigid transform of a constant twist over unit time.
#[must_use]
pub fn exp(twist: &Vector3<f64>) -> Isometry2<f64> {
    let moved = block(twist.z) * twist.xy();
    Isometry2::from_parts(Translation2::from(moved), UnitComplex::new(twist.z))
}

/// Twist of a planar rigid transform, of rotation −π to π; the inverse of [`exp`].
#[must_use]
pub fn log(target_from_source: &Isometry2<f64>) -> Vector3<f64> {
    let angle = target_from_source.rotation.angle();
    let translation = block_inverse(angle) * target_from_source.translation.vector;
    Vector3::new(translation.x, translation.y, angle)
}

/// `exp(ξ) T̂`, with the rotation's length restored.
#[must_use]
pub fn retract(target_from_source: &Isometry2<f64>, twist: &Vector3<f64>) -> Isometry2<f64> {
    let mut moved = exp(twist) * target_from_source;
    moved.rotation.renormalize_fast();
    moved
}

/// `log(T T̂⁻¹)`: the twist that [`retract`] needs to get from `reference` to `target_from_source`.
#[must_use]
pub fn difference(target_from_source: &Isometry2<f64>, reference: &Isometry2<f64>) -> Vector3<f64> {
    log(&(target_from_source * reference.inverse()))
}

/// `Ad(T)`, `3 × 3`: `T exp(ξ) T⁻¹ = exp(Ad(T) ξ)`.
#[must_use]
pub fn adjoint(target_from_source: &Isometry2<f64>) -> Matrix3<f64> {
    let rotation = target_from_source.rotation.to_rotation_matrix().into_inner();
    let t = target_from_source.translation.vector;
    bordered(&rotation, &Vector2::new(t.y, -t.x))
}

/// `J_l(ξ)`, `3 × 3`: `exp(ξ + δ) ≈ exp(J_l(ξ) δ) exp(ξ)`.
#[must_use]
pub fn left_jacobian(twist: &Vector3<f64>) -> Matrix3<f64> {
    bordered(&block(twist.z), &coupling(twist))
}

/// `J_l(ξ)⁻¹`; singular at a rotation of 2π.
#[must_use]
pub fn left_jacobian_inverse(twist: &Vector3<f64>) -> Matrix3<f64> {
    let inverse = block_inverse(twist.z);
    bordered(&inverse, &-(inverse * coupling(twist)))
}

/// `J_r(ξ) = J_l(−ξ)`: `exp(ξ + δ) ≈ exp(ξ) exp(J_r(ξ) δ)`.
#[must_use]
pub fn right_jacobian(twist: &Vector3<f64>) -> Matrix3<f64> {
    left_jacobian(&-twist)
}

/// `J_r(ξ)⁻¹ = J_l(−ξ)⁻¹`.
#[must_use]
pub fn right_jacobian_inverse(twist: &Vector3<f64>) -> Matrix3<f64> {
    left_jacobian_inverse(&-twist)
}

/// `∂(exp(ξ) p)/∂ξ` at ξ = 0, `2 × 3`: `[I, (−p_y, p_x)ᵀ]`.
///
/// `point_mm` is in the target frame, that is, already moved.
#[must_use]
pub fn point_jacobian(point_mm: &Point2<f64>) -> Matrix2x3<f64> {
    Matrix2x3::new(1.0, 0.0, -point_mm.y, 0.0, 1.0, point_mm.x)
}

/// `[sin θ/θ, −(1 − cos θ)/θ; (1 − cos θ)/θ, sin θ/θ]`.
fn block(angle: f64) -> Matrix2<f64> {
    let (diagonal, off) = (sinc(angle), angle * cosc(angle));
    Matrix2::new(diagonal, -off, off, diagonal)
}

fn block_inverse(angle: f64) -> Matrix2<f64> {
    let (diagonal, off) = (half_cot(angle), 0.5 * angle);
    Matrix2::new(diagonal, off, -off, diagonal)
}

/// Last column of the left Jacobian.
fn coupling(twist: &Vector3<f64>) -> Vector2<f64> {
    let along = twist.z * sinc_remainder(twist.z);
    let across = cosc(twist.z);
    Vector2::new(along * twist.x + across * twist.y, along * twist.y - across * twist.x)
}

fn bordered(corner: &Matrix2<f64>, column: &Vector2<f64>) -> Matrix3<f64> {
    let mut out = Matrix3::identity();
    out.fixed_view_mut::<2, 2>(0, 0).copy_from(corner);
    out.fixed_view_mut::<2, 1>(0, 2).copy_from(column);
    out
}
