//! Where the head really is: step 3 of [A].

use nalgebra::{Matrix2, Point2, Vector2};

use crate::{FtCenterError, Handedness, Noise, PressRole, SensorFrame, SolvedPress};

/// How presses are put together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LocateOptions {
    /// Noise of one reading. Default `None`: taken from the records' own scatter.
    pub noise: Option<Noise>,
    /// Handedness where it is known. Default `None`: the points decide.
    pub handedness: Option<Handedness>,
}

/// Every press in the machine frame.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Located {
    /// The sensor in the machine, from the presses of role [`PressRole::Frame`].
    pub frame: SensorFrame,
    /// One per press, in input order.
    pub centers: Vec<Center>,
    /// Degrees of freedom of all covariances: intervals are Student's.
    pub degrees_of_freedom: f64,
    /// Factor by which covariances were widened, because the frame's residual is larger than
    /// the records explain at the 1 % level; 1 where it is not.
    pub widened_by: f64,
}

/// One press in the machine frame.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Center {
    /// Name of the press.
    pub press: String,
    /// What it was for.
    pub role: PressRole,
    /// Centre of the orbit, sensor frame.
    pub sensor_mm: Point2<f64>,
    /// The same point, machine frame.
    pub machine_mm: Point2<f64>,
    /// Found − commanded position, machine frame: what to compensate for a press of role
    /// [`PressRole::Locate`], the residual for the others.
    pub offset_mm: Vector2<f64>,
    /// Covariance of `offset_mm`: orbit and frame together; for a press that the frame was
    /// fitted to, that of the residual.
    pub covariance_mm2: Matrix2<f64>,
}

/// Places the sensor by the frame presses and every press in the machine.
///
/// # Errors
///
/// As [`fit_sensor_frame`](crate::fit_sensor_frame) for the frame presses, and
/// [`FtCenterError::NotPositive`] for the noise.
pub fn locate(presses: &[SolvedPress], options: &LocateOptions) -> Result<Located, FtCenterError> {
    let _ = (presses, options);
    unimplemented!("lands with the next commit")
}
