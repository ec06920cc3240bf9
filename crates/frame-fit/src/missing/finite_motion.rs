//! What a finite motion does, by its parameters, and how these are reported.

use geometry::so3;
use nalgebra::{DVector, SMatrix, SVector, Vector3};

use crate::Transform;
use crate::motion::{Motion, Moved, finite, rotation_vector};

/// Reported unit and factor; the parameters of machines are small.
pub(crate) fn reported(motion: Motion) -> (&'static str, f64) {
    match motion {
        Motion::Translation(_) => ("mm", 1.0),
        Motion::Rotation(_) | Motion::Shear(..) => ("µrad", 1e6),
        Motion::Scale | Motion::Stretch(_) => ("ppm", 1e6),
    }
}

/// `∂y/∂parameters` of [`finite`] at finite `parameters`: each derivative is a motion of its own, of
/// the point before the motion.
pub(crate) fn derivatives<const D: usize>(
    transform: Transform,
    motions: &[Motion],
    parameters: &DVector<f64>,
) -> Vec<Moved<D>> {
    // An affine motion is linear in its parameters, and so is a translation.
    let is_linear = transform == Transform::Affine || !transform.has_rotation();
    let strain = if is_linear {
        SMatrix::zeros()
    } else {
        finite::<D>(transform, motions, parameters).strain
    };
    let moved = SMatrix::identity() + strain;
    let turns = so3::left_jacobian(&rotation_vector(motions, parameters));
    let derivative = |motion: &Motion| match motion {
        // ∂(exp(r) v)/∂r = −[exp(r) v]× J_l(r), column by column.
        Motion::Rotation(axis) if !is_linear => {
            let turn = turns.column(*axis).cross_matrix();
            let turn = SMatrix::<f64, D, D>::from_fn(|row, column| turn[(row, column)]);
            Moved { strain: turn * moved, shift_mm: SVector::zeros() }
        }
        _ => Moved {
            strain: motion.strain::<D>() * moved,
            shift_mm: motion.displacement(&SVector::zeros()),
        },
    };
    motions.iter().map(derivative).collect()
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
