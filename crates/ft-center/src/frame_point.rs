use nalgebra::{Matrix2, Point2, Vector2};

use crate::FtCenterError;

/// Spread of points, as a share of their coordinates, that is no more than round-off.
const MIN_RELATIVE_SPREAD: f64 = 1e-12;

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

/// Validates points; returns the smaller of their spreads in the two frames.
pub(crate) fn check_points(points: &[FramePoint], needed: usize) -> Result<f64, FtCenterError> {
    if points.len() < needed {
        return Err(FtCenterError::TooFewFramePoints { got: points.len(), needed });
    }
    let finite = |p: &FramePoint| {
        let numbers = p.machine_mm.iter().chain(p.sensor_mm.iter()).chain(p.covariance_mm2.iter());
        numbers.into_iter().all(|v| v.is_finite())
    };
    if let Some(index) = points.iter().position(|p| !finite(p)) {
        return Err(FtCenterError::NotFinite { index });
    }
    let machine = spread(points.iter().map(|p| p.machine_mm.coords));
    let sensor = spread(points.iter().map(|p| p.sensor_mm.coords));
    for (spread_mm, size_mm) in [machine, sensor] {
        // NaN: coordinates so large that their squares overflow.
        if spread_mm.is_nan() {
            return Err(FtCenterError::OutOfRange);
        }
        if spread_mm <= MIN_RELATIVE_SPREAD * size_mm {
            return Err(FtCenterError::CoincidentPoints { spread_mm });
        }
    }
    Ok(machine.0.min(sensor.0))
}

/// Root mean square distance from the centroid, and largest coordinate.
fn spread(points: impl Iterator<Item = Vector2<f64>> + Clone) -> (f64, f64) {
    let n = crate::count(points.clone().count());
    let mean = points.clone().sum::<Vector2<f64>>() / n;
    let square: f64 = points.clone().map(|p| (p - mean).norm_squared()).sum();
    let size = points.map(|p| p.amax()).fold(0.0, f64::max);
    let rms = (square / n).sqrt();
    (if rms.is_finite() { rms } else { f64::NAN }, size)
}

/// For each point the matrix that turns its error into two unit errors.
pub(crate) fn whitening(points: &[FramePoint]) -> Result<Vec<Matrix2<f64>>, FtCenterError> {
    let whiten = |(index, p): (usize, &FramePoint)| {
        let factor = p.covariance_mm2.cholesky().and_then(|c| c.l().try_inverse());
        factor.ok_or(FtCenterError::InvalidCovariance { index })
    };
    points.iter().enumerate().map(whiten).collect()
}
