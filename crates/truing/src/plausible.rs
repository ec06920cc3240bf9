//! Whether what is handed back can be true of a machine.

use crate::{Error, Estimates};

/// Refuses a deliverable that no machine needs; `max_correction_deg` replaces the bound of a
/// compensation, one degree.
///
/// # Errors
///
/// [`Error::Implausible`] with the field to look at and, where the data tell, the value that fits.
pub fn plausible(estimates: &dyn Estimates, max_correction_deg: Option<f64>) -> Result<(), Error> {
    let problem = estimates.implausible(max_correction_deg);
    problem.map_or(Ok(()), |problem| Err(Error::Implausible { problem: Box::new(problem) }))
}
