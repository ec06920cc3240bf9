//! Where the head really is: step 3 of \[A\].

use least_squares::between_variance;
use nalgebra::{DMatrix, DVector, Matrix2, Point2, Vector2};

use crate::press_noise::center_covariances;
use crate::{
    CommandedFrame, Contact, FramePoint, FtCenterError, Handedness, Noise, PressRole, SensorFrame,
    SolvedPress, Table, fit_sensor_frame,
};

/// Rounds of weighing and fitting; the seat moves by less than a thousandth in the last.
const REWEIGHTINGS: usize = 3;

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
    /// The sensor in the machine, from the presses of role [`PressRole::Frame`]; its covariance
    /// is scaled by its `variance_factor`.
    pub frame: SensorFrame,
    /// The same as a map of what the machine says, with the scale and the datum that were found.
    pub commanded: CommandedFrame,
    /// What the map leaves out, and when it holds as it is; one sentence each.
    pub conditions: Vec<String>,
    /// One per press, in input order.
    pub centers: Vec<Center>,
    /// Degrees of freedom of all covariances: intervals are Student's.
    pub degrees_of_freedom: f64,
    /// Standard deviation, along each axis, of the scatter from press to press beyond the noise
    /// of the records: how well the head seats. Part of all covariances; zero where the frame
    /// presses show none.
    pub seat_mm: f64,
    /// Farthest press, from the frame's pivot, that the frame was fitted to.
    pub reach_mm: f64,
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
    /// What accepted effects move the head by, machine frame; zero in the declared model.
    pub correction_mm: Vector2<f64>,
    /// Found − commanded position − `correction_mm`, machine frame: the residual of a press whose
    /// position is known. To compensate in a press of role [`PressRole::Locate`]: both together.
    pub offset_mm: Vector2<f64>,
    /// Covariance of `offset_mm`: orbit and frame together; for a press that the frame was
    /// fitted to, that of the residual.
    pub covariance_mm2: Matrix2<f64>,
}

/// Places the sensor by the frame presses and every press in the machine.
///
/// A press is uncertain by the noise within its record and by how well the head seats, which only
/// the frame's residual shows. The seat is estimated by restricted likelihood; covariances are then
/// scaled by the residual's variance factor, and intervals are Student's with its degrees of
/// freedom (Knapp and Hartung 2003). Few frame presses know their own scatter badly, and the
/// intervals say so.
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
    let covariances_mm2 = center_covariances(presses, contact.z0_mm, options.noise)?;
    let points: Vec<_> = presses
        .iter()
        .zip(&covariances_mm2)
        .filter(|(p, _)| p.role == PressRole::Frame)
        .map(|(p, covariance_mm2)| FramePoint {
            machine_mm: p.machine_mm,
            sensor_mm: p.orbit.center_mm,
            covariance_mm2: *covariance_mm2,
        })
        .collect();
    let (mut frame, seat_mm) = frame_with_seat(&points, options.handedness)?;
    let centers = presses
        .iter()
        .zip(&covariances_mm2)
        .map(|(p, covariance)| center(p, &seated(covariance, seat_mm), &frame))
        .collect();
    frame.covariance *= frame.variance_factor;
    let degrees_of_freedom = crate::count(frame.degrees_of_freedom);
    let commanded = CommandedFrame::declared(&frame);
    let reach_mm = reach(points.iter().map(|p| p.machine_mm), &frame);
    Ok(Located {
        frame,
        commanded,
        conditions: Vec::new(),
        centers,
        degrees_of_freedom,
        seat_mm,
        reach_mm,
    })
}

/// Farthest of the positions from the pivot of a frame.
pub(crate) fn reach(at: impl Iterator<Item = Point2<f64>>, frame: &SensorFrame) -> f64 {
    at.map(|p| (p - frame.pivot_mm).norm()).fold(0.0, f64::max)
}

/// The frame, and how well the head seats, each weighed by the other.
fn frame_with_seat(
    points: &[FramePoint],
    handedness: Option<Handedness>,
) -> Result<(SensorFrame, f64), FtCenterError> {
    let mut frame = fit_sensor_frame(points, handedness)?;
    let mut seat_mm = 0.0;
    for _ in 0..REWEIGHTINGS {
        seat_mm = seat(points, &frame).sqrt();
        let weighed: Vec<_> = (points.iter())
            .map(|p| FramePoint { covariance_mm2: seated(&p.covariance_mm2, seat_mm), ..*p })
            .collect();
        frame = fit_sensor_frame(&weighed, handedness)?;
    }
    Ok((frame, seat_mm))
}

/// Variance of the seat along each axis, mm².
fn seat(points: &[FramePoint], frame: &SensorFrame) -> f64 {
    let variances = points.iter().flat_map(|p| [p.covariance_mm2.m11, p.covariance_mm2.m22]);
    let sigma: Vec<f64> = variances.map(f64::sqrt).collect();
    let residual = DVector::from_fn(sigma.len(), |i, _| frame.residuals_mm[i / 2][i % 2]);
    let mut jacobian = DMatrix::zeros(sigma.len(), 3);
    for (i, point) in points.iter().enumerate() {
        let block = frame.position_jacobian(&point.machine_mm);
        jacobian.fixed_view_mut::<2, 3>(2 * i, 0).copy_from(&block);
    }
    between_variance(&sigma, |_| true, &residual, &jacobian)
}

fn seated(covariance_mm2: &Matrix2<f64>, seat_mm: f64) -> Matrix2<f64> {
    covariance_mm2 + Matrix2::identity() * seat_mm.powi(2)
}

fn center(press: &SolvedPress, covariance: &Matrix2<f64>, frame: &SensorFrame) -> Center {
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
        correction_mm: Vector2::zeros(),
        offset_mm: machine_mm - press.machine_mm,
        covariance_mm2: back.linear * sum * back.linear.transpose() * frame.variance_factor,
    }
}
