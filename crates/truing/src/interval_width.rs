use model_discrepancy::coverage_factor;
use serde::Serialize;

/// How wide a 95 % interval is in standard uncertainties.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct IntervalWidth {
    /// Half width over the standard uncertainty: 1.96 where the noise was declared, else Student's
    /// quantile; `None` where nothing is redundant.
    pub coverage_factor: Option<f64>,
    /// Degrees of freedom with which the noise was estimated; `None` where it was declared.
    pub degrees_of_freedom: Option<usize>,
}

impl IntervalWidth {
    pub(crate) fn new(degrees_of_freedom: Option<usize>) -> Self {
        let factor = coverage_factor(degrees_of_freedom);
        Self { coverage_factor: Some(factor).filter(|f| f.is_finite()), degrees_of_freedom }
    }
}
