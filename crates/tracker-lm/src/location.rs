//! Where the axis really is: the harmonics that its misplacement puts into the six errors.

use geometry::so3;
use nalgebra::{Matrix3, Matrix4, SMatrix, Vector3, Vector4, Vector6};

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
        design * self.errors
    }
}

/// `∂ errors / ∂ location`, `6 × 4`.
fn harmonics(axis: &RotaryAxis, angle_rad: f64) -> SMatrix<f64, 6, 4> {
    let rotation = so3::exp(&(axis.direction.into_inner() * angle_rad));
    let missing = Matrix3::identity() - rotation.to_rotation_matrix().into_inner();
    let across = axis.letter.across();
    let mut design = SMatrix::<f64, 6, 4>::zeros();
    for (i, machine_axis) in across.into_iter().enumerate() {
        let column = missing * Vector3::ith(machine_axis, 1.0);
        design.fixed_view_mut::<3, 1>(0, i).copy_from(&column);
        design.fixed_view_mut::<3, 1>(3, 2 + i).copy_from(&column);
    }
    design
}

/// Four sums over angles, `Σ Aₖ·errorₖ`.
pub(crate) type AngleFit = Vec<SMatrix<f64, 4, 6>>;

/// The sums that fit the location of an axis by least squares, from its first angle on.
///
/// `None` where the angles hardly differ.
pub(crate) fn angle_fit(axis: &RotaryAxis, angles_rad: &[f64]) -> Option<AngleFit> {
    /// Mean square of a harmonic below which it does not show: an arc of 0.06°.
    const SMALLEST: f64 = 1e-6;
    let first_angle_rad = *angles_rad.first()?;
    let design = |angle: &f64| harmonics(axis, angle - first_angle_rad);
    let normal: Matrix4<f64> = angles_rad.iter().map(design).map(|d| d.tr_mul(&d)).sum();
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let mean = normal / angles_rad.len() as f64;
    let least = mean.symmetric_eigenvalues().min();
    if least.is_nan() || least <= SMALLEST {
        return None;
    }
    let factor = normal.cholesky()?;
    Some(angles_rad.iter().map(|angle| factor.solve(&design(angle).transpose())).collect())
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
