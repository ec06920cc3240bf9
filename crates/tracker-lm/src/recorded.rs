//! Times and conditions that were recorded beside readings, one value each.

use model_discrepancy::Covariate;

use crate::TrackerError;

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
