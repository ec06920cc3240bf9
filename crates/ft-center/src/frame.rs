//! Planar frame between machine and sensor: (1.12) to (1.14) of [A].

use geometry::PlanarMap;
use nalgebra::{Matrix2, Matrix3, Point2, Vector2};

use crate::FtCenterError;

/// One position known in the machine and found by the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FramePoint {
    /// Where the head was, machine frame.
    pub machine_mm: Point2<f64>,
    /// Where the sensor found it.
    pub sensor_mm: Point2<f64>,
    /// Covariance of `sensor_mm`, positive definite.
    pub covariance_mm2: Matrix2<f64>,
}

/// Whether the sensor's z points the way the machine's does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Handedness {
    /// z axes agree: the planar map is a rotation.
    Same,
    /// z axes oppose each other: the planar map is a reflection.
    Opposed,
}

/// How the handedness of a frame is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum HandednessSource {
    /// The points fit one and miss the other.
    Measured,
    /// Given by the caller.
    Given,
    /// The points, two or on one line, fit both alike: z axes are taken to agree.
    Assumed,
}

/// Rigid planar frame of the sensor in the machine.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SensorFrame {
    /// Angle θ of `sensor = Rot(θ) · Mirror · machine + translation`; Mirror is diag(1, −1)
    /// where the z axes oppose each other.
    pub angle_rad: f64,
    /// Translation of the same map: the machine's origin in the sensor frame.
    pub translation_mm: Vector2<f64>,
    /// Whether the map reflects.
    pub handedness: Handedness,
    /// How that is known.
    pub handedness_source: HandednessSource,
    /// Root mean square miss of the best frame of the other handedness.
    pub other_handedness_rms_mm: f64,
    /// Covariance of `[angle_rad, pivot x, pivot y]` for the given point covariances; rad², mm.
    ///
    /// The pivot is the image of `pivot_mm`; about it the angle moves nothing, so that far away
    /// origins do no harm.
    pub covariance: Matrix3<f64>,
    /// Weighted centroid of the machine positions.
    pub pivot_mm: Point2<f64>,
    /// Sensor position found − position predicted, sensor frame, in input order.
    pub residuals_mm: Vec<Vector2<f64>>,
    /// `2 n − 3`.
    pub degrees_of_freedom: usize,
    /// Weighted sum of squares over `degrees_of_freedom`; near 1 when the covariances are honest.
    pub variance_factor: f64,
}

impl SensorFrame {
    /// The map from machine to sensor coordinates, the direction of [A].
    #[must_use]
    pub fn sensor_from_machine(&self) -> PlanarMap {
        PlanarMap::rigid(
            self.angle_rad,
            self.handedness == Handedness::Opposed,
            self.translation_mm,
        )
    }

    /// The map from sensor to machine coordinates.
    #[must_use]
    pub fn machine_from_sensor(&self) -> PlanarMap {
        let there = self.sensor_from_machine();
        let linear = there.linear.transpose();
        PlanarMap { linear, translation_mm: -(linear * there.translation_mm) }
    }
}

/// Fits the rigid frame to two or more points; more than two tell a reflection.
///
/// `handedness` holds it where it is known; `None` lets the points decide.
///
/// # Errors
///
/// [`FtCenterError::TooFewFramePoints`], [`FtCenterError::CoincidentPoints`],
/// [`FtCenterError::NotFinite`], [`FtCenterError::InvalidCovariance`].
pub fn fit_sensor_frame(
    points: &[FramePoint],
    handedness: Option<Handedness>,
) -> Result<SensorFrame, FtCenterError> {
    let _ = (points, handedness);
    unimplemented!("lands with the next commit")
}

/// General affine map, the `T = S P⁻¹` of (1.14) in [A], as a diagnostic of the rigid frame.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AffineFrame {
    /// Maps machine to sensor coordinates.
    pub sensor_from_machine: PlanarMap,
    /// Larger and smaller scale: singular values of the linear part, 1 for a rigid map.
    pub singular_values: [f64; 2],
    /// Standard uncertainty of the linear part's entries, as large as the largest of them.
    pub linear_std_ratio: f64,
    /// Deviation of the angle between the axes from a right angle.
    pub shear_rad: f64,
    /// Sensor position found − position predicted, in input order.
    pub residuals_mm: Vec<Vector2<f64>>,
    /// `2 n − 6`.
    pub degrees_of_freedom: usize,
}

/// Fits the affine map to three or more points; three leave no residual.
///
/// # Errors
///
/// [`FtCenterError::TooFewFramePoints`], [`FtCenterError::CollinearPoints`],
/// [`FtCenterError::NotFinite`], [`FtCenterError::InvalidCovariance`].
pub fn fit_affine_frame(points: &[FramePoint]) -> Result<AffineFrame, FtCenterError> {
    let _ = points;
    unimplemented!("lands with the next commit")
}
