//! Affine frame: the `T = S P⁻¹` of (1.14) in \[A\].

use geometry::PlanarMap;
use nalgebra::{DMatrix, DVector, Matrix2, Matrix2x3, Vector2, Vector3};

use crate::FtCenterError;
use crate::frame_point::{FramePoint, check_points, whitening};

/// Spread across a line over spread along it under which the map across is free.
const MIN_RELATIVE_SPREAD: f64 = 1e-9;

/// General affine map, as a diagnostic of the rigid frame.
///
/// Its six unknowns fit three points without residual, whatever their errors: what is wrong
/// shows in the scales and the shear alone.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AffineFrame {
    /// Maps machine to sensor coordinates.
    pub sensor_from_machine: PlanarMap,
    /// Singular values of the linear part, larger first; both 1 for a rigid map.
    pub scale_ratios: [f64; 2],
    /// Deviation from a right angle between the images of the machine's axes, positive when
    /// the angle is larger.
    pub shear_rad: f64,
    /// Standard uncertainty of each entry of the linear part, for the given covariances.
    pub linear_std_ratio: Matrix2<f64>,
    /// Sensor position found − position predicted, in input order.
    pub residuals_mm: Vec<Vector2<f64>>,
    /// `2 n − 6`.
    pub degrees_of_freedom: usize,
}

/// Fits the affine map to three or more points off one line.
///
/// # Errors
///
/// [`FtCenterError::TooFewFramePoints`], [`FtCenterError::CollinearPoints`],
/// [`FtCenterError::NotFinite`], [`FtCenterError::InvalidCovariance`],
/// [`FtCenterError::OutOfRange`].
pub fn fit_affine_frame(points: &[FramePoint]) -> Result<AffineFrame, FtCenterError> {
    check_points(points, 3)?;
    let n = crate::count(points.len());
    let center = points.iter().map(|p| p.machine_mm.coords).sum::<Vector2<f64>>() / n;
    let size_mm = check_off_line(points, &center)?;
    // Coordinates from the centroid, in units of the spread: all columns of the same size.
    let arm = |p: &FramePoint| {
        let d = (p.machine_mm.coords - center) / size_mm;
        Vector3::new(d.x, d.y, 1.0)
    };
    let mut design = DMatrix::zeros(2 * points.len(), 6);
    let mut observed = DVector::zeros(2 * points.len());
    for (i, (p, whiten)) in points.iter().zip(whitening(points)?).enumerate() {
        let arm = arm(p).transpose();
        for axis in 0..2 {
            let block = whiten.column(axis) * arm;
            design.fixed_view_mut::<2, 3>(2 * i, 3 * axis).copy_from(&block);
        }
        observed.fixed_rows_mut::<2>(2 * i).copy_from(&(whiten * p.sensor_mm.coords));
    }
    let qr = design.qr();
    let r = qr.r();
    let free = FtCenterError::CollinearPoints { spreads_mm: [size_mm, 0.0] };
    let solved = r.solve_upper_triangular(&(qr.q().transpose() * observed)).ok_or(free.clone())?;
    let inverse = r.solve_upper_triangular(&DMatrix::identity(6, 6)).ok_or(free)?;
    let std = |k: usize| inverse.row(k).norm() / size_mm;

    let rows = Matrix2x3::from_row_slice(solved.as_slice());
    let linear = rows.fixed_columns::<2>(0) / size_mm;
    let translation_mm = rows.column(2) - linear * center;
    let sensor_from_machine = PlanarMap { linear, translation_mm };
    let parts = sensor_from_machine.parts();
    let (x, y) = (linear.column(0), linear.column(1));
    let finite = linear.iter().chain(translation_mm.iter()).all(|v| v.is_finite());
    if !finite {
        return Err(FtCenterError::OutOfRange);
    }
    let image_of = |p: &FramePoint| rows * arm(p);
    Ok(AffineFrame {
        sensor_from_machine,
        scale_ratios: [parts.major_scale, parts.minor_scale],
        shear_rad: -(x.dot(&y) / (x.norm() * y.norm())).clamp(-1.0, 1.0).asin(),
        linear_std_ratio: Matrix2::new(std(0), std(1), std(3), std(4)),
        residuals_mm: points.iter().map(|p| p.sensor_mm.coords - image_of(p)).collect(),
        degrees_of_freedom: 2 * points.len() - 6,
    })
}

/// Root mean square spread of the machine positions, if they are not on one line.
fn check_off_line(points: &[FramePoint], center: &Vector2<f64>) -> Result<f64, FtCenterError> {
    let n = crate::count(points.len());
    let arms = DMatrix::from_fn(points.len(), 2, |i, axis| {
        (points[i].machine_mm[axis] - center[axis]) / n.sqrt()
    });
    let spreads = arms.singular_values();
    let spreads_mm = [spreads[0], spreads[1]];
    if spreads_mm[1] > MIN_RELATIVE_SPREAD * spreads_mm[0] {
        Ok(spreads_mm[0].hypot(spreads_mm[1]))
    } else {
        Err(FtCenterError::CollinearPoints { spreads_mm })
    }
}
