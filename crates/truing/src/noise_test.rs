//! What the tests of the whole model say: in the JSON, and as warnings.

use model_discrepancy::{LackOfFit, lack_of_fit};
use serde::Serialize;

use crate::Case;

/// Whether readings of one place agree with each other better than with the model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Repeats {
    /// Probability of so much agreement among repeats by chance.
    pub p_value: f64,
    /// Places that are visited more than once.
    pub levels: usize,
    /// Visits to them beyond the first.
    pub repeats: usize,
}

impl Repeats {
    pub(crate) fn of(test: &LackOfFit) -> Self {
        Self { p_value: test.p_value, levels: test.levels, repeats: test.repeats }
    }

    /// One line for people.
    pub(crate) fn line(&self) -> String {
        format!(
            "lack of fit: p = {:.2e} ({} places, visited {} times more)",
            self.p_value, self.levels, self.repeats
        )
    }
}

/// Most observations for which repeats are looked for: the declared model is fitted once more.
const MOST_OBSERVATIONS: usize = 5000;

/// The test of lack of fit of a case's declared model, and its warning.
///
/// What cannot be tested, with too few groups for one, is no reason not to solve.
pub(crate) fn repeats(case: &Case, observations: usize) -> (Option<Repeats>, Option<String>) {
    if observations > MOST_OBSERVATIONS || !case.measured.repeats_places() {
        return (None, None);
    }
    let test = (case.measured.prepare().ok())
        .and_then(|prepared| lack_of_fit(&*prepared.model, &prepared.covariates).ok()?);
    let warning = test.as_ref().filter(|test| test.is_significant()).map(|test| {
        format!(
            "lack of fit: repeats of {} places agree with each other far better than with the \
             model (p = {:.1e}); what repeats is no noise, and the stated uncertainties do not \
             hold for it: close the loop to see what it follows",
            test.levels, test.p_value
        )
    });
    (test.as_ref().map(Repeats::of), warning)
}

/// What χ² says of the stated uncertainties; `None` inside its interval.
pub(crate) fn scatter_warning(
    chi2_per_dof: Option<f64>,
    chi2_interval: Option<[f64; 2]>,
) -> Option<String> {
    let (chi2, [low, high]) = chi2_per_dof.zip(chi2_interval)?;
    let ratio = chi2.sqrt();
    let interval = format!("χ²/dof {}, expected {low:.2} to {high:.2}", times(chi2));
    if chi2 > high {
        Some(format!(
            "the data scatter {0} times as much as the declared noise allows ({interval}): the \
             model lacks something, the input is wrong, or the noise was declared too small; if it \
             is the noise, all stated uncertainties are to be multiplied by {0}",
            times(ratio)
        ))
    } else if chi2 < low {
        Some(format!(
            "the data scatter only {} times as much as declared ({interval}): the noise was \
             declared too large, or the readings are not independent; the stated uncertainties \
             are wider than the data need",
            times(ratio)
        ))
    } else {
        None
    }
}

/// A ratio to two digits, whole from ten on.
fn times(ratio: f64) -> String {
    if ratio >= 1e6 {
        format!("{ratio:.1e}")
    } else if ratio >= 10.0 {
        format!("{ratio:.0}")
    } else {
        format!("{ratio:.2}")
    }
}

#[cfg(test)]
mod tests {
    use super::scatter_warning;

    #[test]
    fn warning_says_how_many_times_and_which_way() {
        assert_eq!(scatter_warning(Some(1.1), Some([0.5, 1.7])), None);
        assert_eq!(scatter_warning(None, None), None);
        let above = scatter_warning(Some(16.0), Some([0.5, 1.7])).expect("far outside");
        assert!(above.contains("4.00 times as much as the declared noise"), "{above}");
        let below = scatter_warning(Some(0.25), Some([0.5, 1.7])).expect("far outside");
        assert!(below.contains("only 0.50 times"), "{below}");
    }
}
