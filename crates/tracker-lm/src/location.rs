//! Where the axis really is: the harmonics that its misplacement puts into the six errors.

use geometry::so3;
use nalgebra::{DMatrix, Matrix3, Matrix4, Vector3, Vector4, Vector6};

use crate::RotaryAxis;

/// Location errors of the axis against its nominal place, ISO 230-1.
///
/// An axis displaced by d and tilted by τ turns points about another line than the nominal one,
/// which shows in the errors relative to the first angle as `(I − R)·d` and `(I − R)·τ`, R the
/// rotation from the first angle. The four harmonics are fitted by least squares over the angles;
/// the six errors themselves still contain them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AxisLocation {
    /// For B: EX0B, EZ0B (mm), EA0B, EC0B (rad); for the others likewise.
    pub errors: Vector4<f64>,
    /// Their covariance.
    pub covariance: Matrix4<f64>,
    axis: RotaryAxis,
    first_angle_rad: f64,
}

impl AxisLocation {
    /// Share of the six errors at an angle that the location makes, `[x y z a b c]`, fixed frame.
    #[must_use]
    pub fn share(&self, angle_rad: f64) -> Vector6<f64> {
        let design = harmonics(&self.axis, angle_rad - self.first_angle_rad);
        Vector6::from_iterator((design * self.errors).iter().copied())
    }
}

/// `∂ errors / ∂ location`, `6 × 4`.
fn harmonics(axis: &RotaryAxis, angle_rad: f64) -> DMatrix<f64> {
    let rotation = so3::exp(&(axis.direction.into_inner() * angle_rad));
    let missing = Matrix3::identity() - rotation.to_rotation_matrix().into_inner();
    let across = axis.letter.across();
    let mut design = DMatrix::zeros(6, 4);
    for (i, machine_axis) in across.into_iter().enumerate() {
        let column = missing * Vector3::ith(machine_axis, 1.0);
        design.fixed_view_mut::<3, 1>(0, i).copy_from(&column);
        design.fixed_view_mut::<3, 1>(3, 2 + i).copy_from(&column);
    }
    design
}

/// `location = Σ Aₖ·errorₖ`: the matrices of the least-squares fit, `4 × 6` per angle.
///
/// `None` where the angles hardly differ.
pub(crate) fn fit_matrices(axis: &RotaryAxis, angles_rad: &[f64]) -> Option<Vec<DMatrix<f64>>> {
    /// Mean square of a harmonic below which it does not show: an arc of 0.06°.
    const SMALLEST: f64 = 1e-6;
    let first = *angles_rad.first()?;
    let designs: Vec<_> = angles_rad.iter().map(|a| harmonics(axis, a - first)).collect();
    let normal = designs.iter().fold(DMatrix::zeros(4, 4), |sum, d| sum + d.tr_mul(d));
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let mean = &normal / angles_rad.len() as f64;
    let least = mean.symmetric_eigenvalues().min();
    if least.is_nan() || least <= SMALLEST {
        return None;
    }
    let factor = normal.cholesky()?;
    Some(designs.iter().map(|d| factor.solve(&d.transpose())).collect())
}

/// The location that errors in the fixed frame show, with its covariance.
pub(crate) fn located(
    axis: RotaryAxis,
    first_angle_rad: f64,
    errors: Vector4<f64>,
    covariance: Matrix4<f64>,
) -> AxisLocation {
    AxisLocation { errors, covariance, axis, first_angle_rad }
}
