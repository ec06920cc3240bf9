//! What a finite motion does, by its parameters, and how these are reported.

use geometry::so3;
use nalgebra::{DMatrix, DVector, SMatrix, SVector, Vector3};

use crate::Transform;
use crate::motion::{Motion, finite, jacobian, rotation_vector};

/// Reported unit and factor; the parameters of machines are small.
pub(crate) fn reported(motion: Motion) -> (&'static str, f64) {
    match motion {
        Motion::Translation(_) => ("mm", 1.0),
        Motion::Rotation(_) | Motion::Shear(..) => ("µrad", 1e6),
        Motion::Scale | Motion::Stretch(_) => ("ppm", 1e6),
    }
}

/// `∂y/∂parameters` of [`finite`] at finite `parameters`, `D × parameters`; `arm_mm` is that of
/// the point before the motion.
pub(crate) fn finite_jacobian<const D: usize>(
    transform: Transform,
    motions: &[Motion],
    parameters: &DVector<f64>,
    arm_mm: &SVector<f64, D>,
) -> DMatrix<f64> {
    // An affine motion is linear in its parameters, and so is a translation.
    if transform == Transform::Affine || !transform.has_rotation() {
        return jacobian(motions, arm_mm);
    }
    let moved_mm = arm_mm + finite(transform, motions, parameters).strain * arm_mm;
    let turns = rotation_derivative(&rotation_vector(motions, parameters), &moved_mm);
    let mut jacobian = DMatrix::zeros(D, motions.len());
    for (column, motion) in motions.iter().enumerate() {
        let derivative = match motion {
            Motion::Rotation(axis) => turns.column(*axis).into_owned(),
            _ => motion.displacement(&moved_mm),
        };
        jacobian.fixed_view_mut::<D, 1>(0, column).copy_from(&derivative);
    }
    jacobian
}

/// `∂(exp(r) v)/∂r`, `D × 3`, from the rotated `v`: `−[exp(r) v]× J_l(r)`.
pub(crate) fn rotation_derivative<const D: usize>(
    rotation_rad: &Vector3<f64>,
    rotated_mm: &SVector<f64, D>,
) -> SMatrix<f64, D, 3> {
    let rotated = Vector3::from_fn(|k, _| if k < D { rotated_mm[k] } else { 0.0 });
    let derivative = -rotated.cross_matrix() * so3::left_jacobian(rotation_rad);
    SMatrix::from_fn(|row, column| derivative[(row, column)])
}
