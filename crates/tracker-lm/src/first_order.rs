//! What the six errors do to a point: to the first order, and exactly.

use std::fmt::Write as _;

use geometry::so3;
use nalgebra::{Matrix3, SMatrix, Vector3};

use crate::{AxisError, AxisLetter, ErrorOrder, RotaryAxis};

/// The first-order map of document \[B\], ΔP = B·E: displacement of a point by the six errors
/// `[EX EY EZ EA EB EC]`, mm and rad, of the fixed frame.
///
/// With the arm q from the axis' origin to the point as the nominal axis has it, machine frame:
/// `B = [1 0 0 0 qz −qy; 0 1 0 −qz 0 qx; 0 0 1 qy −qx 0]` (the document has the rotations first). What it leaves out
/// is at most ½|ω|²|q|, ω the three rotations: 0.13 nm for 50 µrad at 100 mm.
#[must_use]
pub fn error_map(arm_mm: &Vector3<f64>) -> SMatrix<f64, 3, 6> {
    let mut map = SMatrix::<f64, 3, 6>::zeros();
    map.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::identity());
    map.fixed_view_mut::<3, 3>(0, 3).copy_from(&-arm_mm.cross_matrix());
    map
}

/// Where a point that turns with an axis is, beside where the nominal axis has it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PointError {
    /// Angle of the axis.
    pub angle_rad: f64,
    /// From the axis' origin to the point, machine frame, as the nominal axis has it.
    pub arm_mm: Vector3<f64>,
    /// ΔP = B·E, machine frame.
    pub displacement_mm: Vector3<f64>,
    /// Its covariance, B·C·Bᵀ.
    pub covariance_mm2: Matrix3<f64>,
    /// `e + exp(ω)·q − q`, without the linearisation.
    pub exact_mm: Vector3<f64>,
}

impl PointError {
    /// Of one angle, with errors of the fixed frame.
    #[must_use]
    pub fn of(error: &AxisError, arm_mm: Vector3<f64>) -> Self {
        let map = error_map(&arm_mm);
        let [shift, turn] = [0, 3].map(|first| error.error.fixed_rows::<3>(first).into_owned());
        // (exp ω − 1)·q by the sines of half the angle, which keeps the digits of micro-radians.
        let angle = turn.norm();
        let half = (0.5 * angle).sin();
        let sinc = if angle > 0.0 { angle.sin() / angle } else { 1.0 };
        let versine = if angle > 0.0 { 2.0 * half * half / (angle * angle) } else { 0.5 };
        let across = turn.cross(&arm_mm);
        let turned = across * sinc + turn.cross(&across) * versine;
        Self {
            angle_rad: error.angle_rad,
            arm_mm,
            displacement_mm: map * error.error,
            covariance_mm2: map * error.covariance * map.transpose(),
            exact_mm: shift + turned,
        }
    }

    /// Standard uncertainties of the displacement.
    #[must_use]
    pub fn sigmas_mm(&self) -> Vector3<f64> {
        self.covariance_mm2.diagonal().map(|v| v.max(0.0).sqrt())
    }
}

/// The displacement at every angle of a point given in the frame that turns with the axis; `order` is
/// that of the errors.
#[must_use]
pub fn point_errors(
    axis: &RotaryAxis,
    order: ErrorOrder,
    errors: &[AxisError],
    point_mm: &Vector3<f64>,
) -> Vec<PointError> {
    let one = |error: &AxisError| {
        let rotation = axis.rotation(error.angle_rad);
        PointError::of(&fixed_frame_error(axis, order, error), rotation * point_mm)
    };
    errors.iter().map(one).collect()
}

/// Errors that were given in the frame asked for, in the fixed one.
#[must_use]
pub fn fixed_frame_error(axis: &RotaryAxis, order: ErrorOrder, error: &AxisError) -> AxisError {
    if order == ErrorOrder::Fixed {
        return error.clone();
    }
    let rotation = so3::exp(&(axis.direction.into_inner() * error.angle_rad));
    let rotation = rotation.to_rotation_matrix().into_inner();
    let mut turned = SMatrix::<f64, 6, 6>::zeros();
    turned.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation);
    turned.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation);
    AxisError {
        error: turned * error.error,
        covariance: turned * error.covariance * turned.transpose(),
        ..error.clone()
    }
}

/// CSV of displacements, ascending: angle, arm (the map of the first order is B of it), ΔP = B·E with standard
/// uncertainties, and the exact displacement.
#[must_use]
pub fn point_errors_csv(letter: AxisLetter, errors: &[PointError]) -> String {
    let mut text = format!(
        "# axis {}; displacement = B·errors, exact = without linearisation\n",
        letter.letter()
    );
    text.push_str("angle_deg");
    for name in ["arm", "displacement", "std", "exact"] {
        for axis in ["x", "y", "z"] {
            let _ = write!(text, ",{name}_{axis}_mm");
        }
    }
    text.push('\n');
    let mut sorted: Vec<&PointError> = errors.iter().collect();
    sorted.sort_by(|a, b| a.angle_rad.total_cmp(&b.angle_rad));
    for error in sorted {
        let _ = write!(text, "{}", error.angle_rad.to_degrees());
        for value in &error.arm_mm {
            let _ = write!(text, ",{value:.6}");
        }
        let sigmas = error.sigmas_mm();
        for value in error.displacement_mm.iter().chain(&sigmas).chain(&error.exact_mm) {
            let _ = write!(text, ",{value:.9e}");
        }
        text.push('\n');
    }
    text
}
