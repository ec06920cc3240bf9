//! Uncertainty by drawing the data anew, beside the linear one.

use rayon::prelude::*;
use serde::Serialize;

use crate::case::Problem;
use crate::count::count;
use crate::drawn::drawn;
use crate::estimated::Estimated;
use crate::estimates::Estimates;
use crate::uncertain::keys;
use crate::{Case, Error};

/// How the numbers that describe a case scatter where its data are drawn anew (JCGM 101:2008).
///
/// Every uncertain number of the tables gets a draw from the normal distribution that `[noise]`, or
/// a column of the table, declares of it; the case is then solved as ever. Each draw has a random
/// stream of its own: the answer does not depend on the number of threads.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MonteCarlo {
    /// Draws asked for.
    pub draws: usize,
    /// Draws of which the declared model could not be solved; they are in no figure.
    pub failed: usize,
    /// Numbers that have a standard uncertainty.
    pub parameters: Vec<DrawnParameter>,
}

/// How one number scatters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DrawnParameter {
    /// Its name.
    pub name: String,
    /// Its unit; empty for a pure number.
    pub unit: &'static str,
    /// Estimate from the data as they are.
    pub value: f64,
    /// Standard uncertainty by linear propagation.
    pub linear_std: f64,
    /// Standard deviation over the draws.
    pub std: f64,
    /// Probabilistically symmetric 95 % coverage interval over the draws.
    pub interval_95: [f64; 2],
}

/// Probability in each tail of a coverage interval.
const TAIL: f64 = 0.025;

/// Solves a case with `draws` data sets that might have been measured as well.
///
/// # Errors
///
/// [`Error::Case`] where the case declares no noise to draw from; what the fit of the data as they are
/// says, or that of the first draw where none can be solved.
pub fn monte_carlo(case: &Case, draws: usize) -> Result<MonteCarlo, Error> {
    let uncertain = case.files.kind.uncertain;
    let refused = |problem| Err(Error::case(case.files.document.at_file(), problem));
    if uncertain.is_empty() {
        let message = format!("results of `{}` have no uncertainty to draw", case.kind);
        return refused(Problem::WrongValue { message });
    }
    if drawn(uncertain, &case.files, 0).is_none() {
        let key = format!("[noise] {}", keys(uncertain).join("`, `"));
        let purpose = "draws are taken from the noise that is declared, and none is";
        return refused(Problem::MissingKey { key, purpose });
    }
    let solved = |estimates: &dyn Estimates| -> Vec<_> {
        let is_uncertain = |p: &Estimated| p.std.is_some_and(|std| std > 0.0);
        estimates.parameters().into_iter().filter(is_uncertain).collect()
    };
    let found = solved(&*case.fit()?.estimates);
    let of_draw = |draw: u64| -> Result<Vec<f64>, Error> {
        let edits = drawn(uncertain, &case.files, draw).unwrap_or_default();
        let fitted = case.with(&edits)?.fit()?;
        let values = solved(&*fitted.estimates);
        Ok(values.into_iter().map(|parameter| parameter.value).collect())
    };
    let all: Vec<_> = (0..draws as u64).into_par_iter().map(of_draw).collect();
    let is_whole = |values: &&Vec<f64>| values.len() == found.len();
    let whole: Vec<&Vec<f64>> = all.iter().flatten().filter(is_whole).collect();
    let failed = draws - whole.len();
    if whole.is_empty() {
        // Every draw has failed, the first as any.
        let message = "no draw of the data can be solved".to_owned();
        return of_draw(0).and(refused(Problem::WrongValue { message }));
    }
    let parameters = found
        .iter()
        .enumerate()
        .map(|(k, parameter)| {
            let near = |value: f64| match parameter.unit {
                // Angles come round.
                "°" => (value - parameter.value + 180.0).rem_euclid(360.0) - 180.0,
                _ => value - parameter.value,
            };
            let mut off: Vec<f64> = whole.iter().map(|values| near(values[k])).collect();
            off.sort_by(f64::total_cmp);
            DrawnParameter {
                name: parameter.name.clone(),
                unit: parameter.unit,
                value: parameter.value,
                linear_std: parameter.std.unwrap_or(f64::NAN),
                std: deviation(&off),
                interval_95: [quantile(&off, TAIL), quantile(&off, 1.0 - TAIL)]
                    .map(|off| parameter.value + off),
            }
        })
        .collect();
    Ok(MonteCarlo { draws, failed, parameters })
}

/// Standard deviation about the mean.
fn deviation(values: &[f64]) -> f64 {
    let n = count(values.len());
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0)).sqrt()
}

/// The value below which a share of the sorted ones lies.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and a count"
    )]
    let rank = (share * count(sorted.len() - 1)).round() as usize;
    sorted[rank]
}
