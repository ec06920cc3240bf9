//! What comes out.

use least_squares::Report;
use nalgebra::{Matrix3, Matrix6, Point3, Vector6};

use crate::{AxesRelation, AxisLocation};

/// A calibrated axis: everything with its standard uncertainty.
///
/// Uncertainties are a priori where the noise was declared; otherwise they rest on
/// [`Calibration::displacement_mm`] as estimated from the residual.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Calibration {
    /// In the order of the survey.
    pub stations: Vec<StationEstimate>,
    /// In the order of stations and mounts.
    pub dead_paths: Vec<DeadPathEstimate>,
    /// In the order of the survey.
    pub mounts: Vec<MountEstimate>,
    /// One per angle, in the order in which the angles were first measured; of two axes those of the
    /// first, from where it stands on.
    pub axis_errors: Vec<AxisError>,
    /// Location of the axis, where the angles show it; of a perfect axis, where it was fitted.
    pub location: Option<AxisLocation>,
    /// Errors of a perfect axis about where it was found, angle by angle, as far as effects were
    /// accepted; `None` of an axis with six errors at every angle.
    pub motion: Option<Vec<AxisError>>,
    /// The second axis of a head with two.
    pub second: Option<SecondCalibration>,
    /// `|P − S| − (l + L)` of every range, in the order of the survey.
    pub residuals_mm: Vec<f64>,
    /// Share of an error of each range that its own residual shows, 0 to 1.
    pub redundancy: Vec<f64>,
    /// Target points measured.
    pub n_points: usize,
    /// Equations minus unknowns.
    pub degrees_of_freedom: usize,
    /// Mean whitened square residual, near 1 when the declared noise is honest.
    pub variance_factor: f64,
    /// Standard uncertainty of one displacement, declared or estimated.
    pub displacement_mm: f64,
    /// How the search went.
    pub report: Report,
}

/// The second of two axes, machine frame where the first one stands.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SecondCalibration {
    /// One per angle, from where it stands on, in the order in which these were first measured.
    pub axis_errors: Vec<AxisError>,
    /// Its location, where the angles show it.
    pub location: Option<AxisLocation>,
    /// How it lies to the first axis; `None` where they are parallel or a location does not show.
    pub relation: Option<AxesRelation>,
}

/// A station.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StationEstimate {
    /// Machine frame.
    pub position_mm: Point3<f64>,
    /// Covariance of the position under the gauge asked for.
    pub covariance_mm2: Matrix3<f64>,
}

/// A dead path.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DeadPathEstimate {
    /// Index of its station.
    pub station: usize,
    /// Index of its mount, where each lock has its own.
    pub mount: Option<usize>,
    /// Distance at which the tracer reads zero.
    pub length_mm: f64,
    /// Standard uncertainty.
    pub sigma_mm: f64,
}

/// A reflector.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MountEstimate {
    /// In the frame that turns with the axis, errors at the first angle taken as zero.
    pub position_mm: Point3<f64>,
    /// Covariance of the position.
    pub covariance_mm2: Matrix3<f64>,
}

/// The six errors at one angle, relative to the first angle.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AxisError {
    /// The angle.
    pub angle_rad: f64,
    /// `[EX EY EZ EA EB EC]`, mm and rad, in the frame asked for.
    pub error: Vector6<f64>,
    /// Their covariance; zero at the first angle.
    pub covariance: Matrix6<f64>,
}

/// Bias of an observation that a test at 0.1 % finds 8 times in 10, over its own standard
/// uncertainty where nothing else is estimated (Baarda 1968).
const NONCENTRALITY: f64 = 4.132;

impl Calibration {
    /// Smallest error of one range that a test of its residual finds (0.1 %, power 80 %).
    ///
    /// Infinite where no residual would show it.
    #[must_use]
    pub fn detectable_bias_mm(&self, range: usize) -> f64 {
        NONCENTRALITY * self.displacement_mm / self.redundancy[range].sqrt()
    }

    /// Root-mean-square residual of the ranges.
    #[must_use]
    pub fn rms_mm(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let n = self.residuals_mm.len() as f64;
        (self.residuals_mm.iter().map(|r| r * r).sum::<f64>() / n).sqrt()
    }
}

impl AxisError {
    /// Standard uncertainties of the six errors.
    #[must_use]
    pub fn sigmas(&self) -> Vector6<f64> {
        self.covariance.diagonal().map(|v| v.max(0.0).sqrt())
    }
}
