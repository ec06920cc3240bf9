//! Zero, weight and centre of gravity of a tool that hangs free from the sensor.

use geometry::Wrench;
use nalgebra::{Point3, SMatrix, Unit, UnitQuaternion, Vector3};

use crate::{FtCenterError, Noise};

/// One static pose with nothing touched.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StaticPose {
    /// Name of the pose.
    pub name: String,
    /// Orientation of the sensor: maps sensor to base coordinates.
    pub base_from_sensor: UnitQuaternion<f64>,
    /// Wrench read, sensor frame, about the sensor's reference point.
    pub wrench: Wrench,
}

/// What is known before the poses are seen.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GravityOptions {
    /// Direction of gravity in the base. Default −z.
    pub gravity: Unit<Vector3<f64>>,
    /// Noise of one reading. Default `None`: estimated from the residual.
    pub noise: Option<Noise>,
}

impl Default for GravityOptions {
    fn default() -> Self {
        Self { gravity: -Vector3::z_axis(), noise: None }
    }
}

/// Zero of the sensor and weight of the tool.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GravityCalibration {
    /// What the sensor reads under no load.
    pub bias: Wrench,
    /// Weight of the tool beyond the sensor.
    pub weight_n: f64,
    /// Centre of gravity of the tool, sensor frame.
    pub center_of_gravity_mm: Point3<f64>,
    /// Covariance of `[bias force, bias moment, weight, centre of gravity]`, a priori where noise
    /// was given, else a posteriori.
    pub covariance: SMatrix<f64, 10, 10>,
    /// Reading − prediction, in input order.
    pub residuals: Vec<Wrench>,
    /// Distance by which the line of action of the weight, zero taken off, misses the centre of
    /// gravity, in input order.
    pub line_miss_mm: Vec<f64>,
    /// `6 n − 10`.
    pub degrees_of_freedom: usize,
}

/// Calibrates zero, weight and centre of gravity from static poses.
///
/// Reading = zero + `W·g` with moment `r × W·g`, `g` the direction of gravity in sensor axes.
///
/// # Errors
///
/// [`FtCenterError::Empty`], [`FtCenterError::NotFinite`], [`FtCenterError::NotPositive`] and
/// [`FtCenterError::PosesNotEnough`], which names what the poses leave free.
pub fn calibrate_gravity(
    poses: &[StaticPose],
    options: &GravityOptions,
) -> Result<GravityCalibration, FtCenterError> {
    let _ = (poses, options);
    unimplemented!("lands with the next commit")
}
