//! Times and conditions that were recorded beside readings, one value each.

use model_discrepancy::Covariate;

use crate::TrackerError;
use crate::count::count;

/// That there is one finite value of each for `needed` readings.
pub(crate) fn check(
    time_s: Option<&[f64]>,
    covariates: &[Covariate],
    needed: usize,
) -> Result<(), TrackerError> {
    for values in time_s.into_iter().chain(covariates.iter().map(|c| c.values.as_slice())) {
        if values.len() != needed || values.iter().any(|v| !v.is_finite()) {
            return Err(TrackerError::InvalidCovariate { needed });
        }
    }
    Ok(())
}

/// Leaves those of the first readings.
pub(crate) fn truncate(time_s: &mut Option<Vec<f64>>, covariates: &mut [Covariate], n: usize) {
    let values = covariates.iter_mut().map(|c| &mut c.values);
    values.chain(time_s).for_each(|values| values.truncate(n));
}

/// Time of every one of `n` readings: from the first one on as recorded, else the share of the run.
pub(crate) fn elapsed(n: usize, time_s: Option<&[f64]>) -> Vec<f64> {
    if let Some(time_s) = time_s {
        let first = time_s.iter().copied().fold(f64::INFINITY, f64::min);
        return time_s.iter().map(|t| t - first).collect();
    }
    (0..n).map(|index| count(index) / count(n.saturating_sub(1).max(1))).collect()
}
