//! What a finite motion does, by its parameters, and how these are reported.

use geometry::so3;
use nalgebra::{DVector, Matrix3, SMatrix, SVector};

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
        Motion::Rotation(axis) if !is_linear => {
            Moved { strain: turn::<D>(&turns, *axis) * moved, shift_mm: SVector::zeros() }
        }
        _ => Moved {
            strain: motion.strain::<D>() * moved,
            shift_mm: motion.displacement(&SVector::zeros()),
        },
    };
    motions.iter().map(derivative).collect()
}

/// The matrix of `∂(exp(r) v)/∂r = [J_l(r) e]× exp(r) v` along one axis `e`, which takes the rotated
/// `exp(r) v`; `left_jacobian` is `J_l(r)`.
pub(crate) fn turn<const D: usize>(
    left_jacobian: &Matrix3<f64>,
    axis: usize,
) -> SMatrix<f64, D, D> {
    let turn = left_jacobian.column(axis).cross_matrix();
    SMatrix::from_fn(|row, column| turn[(row, column)])
}

impl<const D: usize> Moved<D> {
    /// The displacement, taken by a matrix.
    pub(crate) fn turned(&self, by: &SMatrix<f64, D, D>) -> Self {
        Self { strain: by * self.strain, shift_mm: by * self.shift_mm }
    }
}
