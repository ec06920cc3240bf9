use std::collections::BTreeMap;

use model_discrepancy::{Closure, Model, Role, Row, chi2_interval, independent_share, lag_one};
use serde::Serialize;

use crate::measured::Observation;

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
    /// Where `chi2_per_dof` lies 999 times in 1000 where the noise is as declared; wider where
    /// successive readings depend on each other.
    pub chi2_interval: Option<[f64; 2]>,
}

impl Residual {
    /// The same, held against the declared noise.
    pub(crate) fn judged(
        self,
        dof: usize,
        chi2_per_dof: Option<f64>,
        observations: &[Observation],
    ) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let free = dof as f64 * independent(observations);
        let chi2_per_dof = chi2_per_dof.filter(|_| dof > 0);
        let chi2_interval = chi2_per_dof.map(|_| chi2_interval(free));
        Self { dof, chi2_per_dof, chi2_interval, ..self }
    }

    /// Of the model with the effects that the loop accepted.
    pub(crate) fn after(model: &dyn Model, closure: &Closure, unit: &'static str) -> Self {
        let layout = &model.declared().layout;
        let role = |row: &Row| layout.groups[layout.observations[row.observation]].role;
        let mut square_of: BTreeMap<usize, f64> = BTreeMap::new();
        let (mut n, mut equations) = (0, 0);
        for (row, r) in layout.rows.iter().zip(&closure.residuals_after) {
            equations += usize::from(role(row) != Role::Check);
            if role(row) == Role::Fit && row.reported {
                n += 1;
                *square_of.entry(row.observation).or_insert(0.0) += r * r;
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let mean = |sum: f64| sum / square_of.len() as f64;
        let some = !square_of.is_empty();
        Self {
            unit,
            n,
            dof: equations.saturating_sub(closure.covariance.nrows()),
            rms: some.then(|| mean(square_of.values().sum()).sqrt()),
            max_abs: some.then(|| square_of.values().copied().fold(0.0, f64::max).sqrt()),
            chi2_per_dof: closure.after.chi2_per_dof,
            chi2_interval: closure.after.chi2_interval,
        }
    }

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
            chi2_interval: None,
        }
    }
}

/// Share of the fitted residuals, in the order measured, that are independent of each other.
fn independent(observations: &[Observation]) -> f64 {
    let fitted = || observations.iter().filter(|o| o.fitted);
    let components = fitted().map(|o| o.residual.len()).max().unwrap_or(0);
    let series: Vec<Vec<f64>> = (0..components)
        .map(|c| fitted().filter_map(|o| o.residual.get(c)).copied().collect())
        .collect();
    let (correlation, pairs) = lag_one(series.iter().map(Vec::as_slice));
    independent_share(correlation, pairs)
}
