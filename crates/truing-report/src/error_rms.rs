//! An error as a root mean square.

use serde::{Deserialize, Serialize};

/// Root mean square error; `None` where there is no number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rms {
    /// On the data fitted.
    pub train: Option<f64>,
    /// On data the fit never saw.
    pub held_out: Option<f64>,
    /// Standard error of `held_out`.
    pub held_out_std: Option<f64>,
}

impl From<&model_discrepancy::ErrorSummary> for Rms {
    fn from(error: &model_discrepancy::ErrorSummary) -> Self {
        let number = |v: f64| v.is_finite().then_some(v);
        Self {
            train: number(error.train_rms),
            held_out: number(error.held_out_rms),
            held_out_std: number(error.held_out_std),
        }
    }
}
