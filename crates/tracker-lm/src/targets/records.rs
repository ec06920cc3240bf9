//! Times, conditions and bodies that were recorded beside readings of points.

use model_discrepancy::Covariate;

use super::TargetSurvey;
use crate::{TrackerError, recorded};

/// What was recorded beside the readings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TargetRecords {
    /// Time of every reading.
    pub time_s: Option<Vec<f64>>,
    /// One value per reading; those ending in `_c` are temperatures.
    pub covariates: Vec<Covariate>,
    /// The body that every mount is on; empty where all are on one.
    pub bodies: Vec<String>,
}

impl TargetRecords {
    /// That there is one finite value for each reading, and a body for each mount.
    pub(super) fn check(&self, survey: &TargetSurvey) -> Result<(), TrackerError> {
        recorded::check(self.time_s.as_deref(), &self.covariates, survey.targets.len())?;
        if !self.bodies.is_empty() && self.bodies.len() != survey.mounts.len() {
            return Err(TrackerError::InvalidCovariate { needed: survey.mounts.len() });
        }
        Ok(())
    }

    /// Beside the first readings, of the first mounts.
    pub(super) fn of_first(&self, n_readings: usize, n_mounts: usize) -> Self {
        let mut first = self.clone();
        recorded::truncate(&mut first.time_s, &mut first.covariates, n_readings);
        first.bodies.truncate(n_mounts);
        first
    }
}
