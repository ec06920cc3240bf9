//! The solution of the declared model about which that of the loop is linear.

use least_squares::BorderedPoint;

use crate::calibrate::fitted_joint;
use crate::shift::Shift;
use crate::{Calibration, Options, Survey, TrackerError};

/// The solution about which the model is linear.
#[derive(Clone, Debug)]
pub(crate) struct Solved {
    /// Of the declared model.
    pub(crate) calibration: Calibration,
    /// `[stations, dead paths, reflectors]`, and the errors of every angle.
    pub(crate) point: BorderedPoint,
    /// What effects that are part of the solution move, range by range; empty where there are none.
    pub(crate) shifts: Vec<Shift>,
    /// Amplitudes of the axis' own effects that are part of the solution, whose errors are those of
    /// the point; empty where there are none.
    pub(crate) of_axis: Vec<f64>,
}

/// That of the declared model alone.
pub(crate) fn solved(survey: &Survey, options: &Options) -> Result<Solved, TrackerError> {
    let (calibration, point) = fitted_joint(survey, options)?;
    Ok(Solved { calibration, point, shifts: Vec::new(), of_axis: Vec::new() })
}
