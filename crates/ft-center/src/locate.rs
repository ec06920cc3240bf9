//! Where the head really is: step 3 of \[A\].

use nalgebra::{Matrix2, Point2, Vector2};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::press_noise::CenterNoise;
use crate::{
    Contact, FramePoint, FtCenterError, Handedness, Noise, PressRole, SensorFrame, SolvedPress,
    Table, fit_sensor_frame,
};

/// Significance at which the frame's residual counts as larger than the records explain.
const WIDEN_ALPHA: f64 = 0.01;

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
/// Standard uncertainties come from the noise within the records and, through the frame, from
/// that of the frame presses. Where the frame's residual is larger than that, the presses did
/// not repeat as well as each was steady: everything is widened by what the residual shows.
///
/// # Errors
///
/// As [`fit_sensor_frame`](crate::fit_sensor_frame) for the frame presses,
/// [`FtCenterError::PressPosition`], and [`FtCenterError::NotPositive`] for the noise.
pub fn locate(
    presses: &[SolvedPress],
    contact: &Contact,
    options: &LocateOptions,
) -> Result<Located, FtCenterError> {
    if presses.is_empty() {
        return Err(FtCenterError::Empty { of: Table::Presses });
    }
    if let Some(press) = presses.iter().find(|p| p.machine_mm.iter().any(|v| !v.is_finite())) {
        return Err(FtCenterError::PressPosition { name: press.name.clone() });
    }
    let noise = CenterNoise::of(presses, contact.z0_mm, options.noise)?;
    let points: Vec<_> = presses
        .iter()
        .zip(&noise.covariances_mm2)
        .filter(|(p, _)| p.role == PressRole::Frame)
        .map(|(p, covariance_mm2)| FramePoint {
            machine_mm: p.machine_mm,
            sensor_mm: p.orbit.center_mm,
            covariance_mm2: *covariance_mm2,
        })
        .collect();
    let frame = fit_sensor_frame(&points, options.handedness)?;
    let (widened_by, degrees_of_freedom) = widening(&frame, noise.degrees_of_freedom)?;
    let centers = presses
        .iter()
        .zip(&noise.covariances_mm2)
        .map(|(p, covariance)| center(p, covariance, &frame, widened_by))
        .collect();
    Ok(Located { frame, centers, degrees_of_freedom, widened_by })
}

/// Factor on covariances, and their degrees of freedom.
fn widening(frame: &SensorFrame, noise_dof: f64) -> Result<(f64, f64), FtCenterError> {
    let dof = crate::count(frame.degrees_of_freedom);
    let expected = FisherSnedecor::new(dof, noise_dof).map_err(|_| FtCenterError::OutOfRange)?;
    if expected.sf(frame.variance_factor) < WIDEN_ALPHA {
        Ok((frame.variance_factor, dof))
    } else {
        Ok((1.0, noise_dof))
    }
}

fn center(
    press: &SolvedPress,
    covariance: &Matrix2<f64>,
    frame: &SensorFrame,
    widened_by: f64,
) -> Center {
    let back = frame.machine_from_sensor();
    let machine_mm = back.apply(&press.orbit.center_mm);
    // δ(machine) = L (δ(sensor) − J δ(frame)), and the frame is not independent of its presses.
    let seen = frame.position_jacobian(&press.machine_mm);
    let of_frame = seen * frame.covariance * seen.transpose();
    let sum = match press.role {
        PressRole::Frame => covariance - of_frame,
        PressRole::Check | PressRole::Locate => covariance + of_frame,
    };
    Center {
        press: press.name.clone(),
        role: press.role,
        sensor_mm: press.orbit.center_mm,
        machine_mm,
        offset_mm: machine_mm - press.machine_mm,
        covariance_mm2: back.linear * sum * back.linear.transpose() * widened_by,
    }
}
