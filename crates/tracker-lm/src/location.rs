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

/// The sums that fit the location of an axis by least squares, from its first angle on, among those of
/// `count` angles; zero at those that are not its own.
///
/// `None` where the angles hardly differ.
pub(crate) fn angle_fit(
    axis: &RotaryAxis,
    angles_rad: impl Iterator<Item = (usize, f64)> + Clone,
    count: usize,
) -> Option<AngleFit> {
    /// Mean square of a harmonic below which it does not show: an arc of 0.06°.
    const SMALLEST: f64 = 1e-6;
    let (_, first_angle_rad) = angles_rad.clone().next()?;
    let design = |angle_rad: f64| harmonics(axis, angle_rad - first_angle_rad);
    let (mut normal, mut own) = (Matrix4::zeros(), 0.0);
    for (_, angle_rad) in angles_rad.clone() {
        let design = design(angle_rad);
        normal += design.tr_mul(&design);
        own += 1.0;
    }
    let mean = normal / own;
    let least = mean.symmetric_eigenvalues().min();
    if least.is_nan() || least <= SMALLEST {
        return None;
    }
    let factor = normal.cholesky()?;
    let mut fit = vec![SMatrix::zeros(); count];
    for (k, angle_rad) in angles_rad {
        fit[k] = factor.solve(&design(angle_rad).transpose());
    }
    Some(fit)
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
