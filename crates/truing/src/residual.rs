use serde::Serialize;

use crate::kinds::Observation;

/// How far the observations lie from the model.
///
/// An observation (a point, a press, a pose) counts once, by the length of its residual vector:
/// `rms = √(Σ‖r‖²/N)` over the N observations, `max_abs` is the longest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Residual {
    /// Unit of `rms` and `max_abs`.
    pub unit: &'static str,
    /// Number of scalar residuals.
    pub n: usize,
    /// Degrees of freedom: equations minus parameters.
    pub dof: usize,
    /// Root mean square length; `None` without observations.
    pub rms: Option<f64>,
    /// Longest residual; `None` without observations.
    pub max_abs: Option<f64>,
    /// χ² over degrees of freedom; `None` where the noise was not declared or nothing is redundant.
    pub chi2_per_dof: Option<f64>,
}

impl Residual {
    /// Summary of the residuals of `observations`; `None` without any.
    pub(crate) fn of<'o>(
        observations: impl Iterator<Item = &'o Observation>,
        components: usize,
        unit: &'static str,
    ) -> Self {
        let mut n = 0;
        let squares: Vec<f64> = observations
            .map(|o| {
                let reported = &o.residual[..components.min(o.residual.len())];
                n += reported.len();
                reported.iter().map(|r| r * r).sum()
            })
            .collect();
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let mean = |sum: f64| sum / squares.len() as f64;
        let some = !squares.is_empty();
        Self {
            unit,
            n,
            dof: n,
            rms: some.then(|| mean(squares.iter().sum()).sqrt()),
            max_abs: some.then(|| squares.iter().copied().fold(0.0, f64::max).sqrt()),
            chi2_per_dof: None,
        }
    }
}
