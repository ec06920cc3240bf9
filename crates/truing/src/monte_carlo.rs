//! Uncertainty by drawing the data anew, beside the linear one.

use model_discrepancy::Closure;
use rayon::prelude::*;
use serde::Serialize;

use crate::case::Problem;
use crate::count::count;
use crate::drawn::{Source, drawn};
use crate::estimates::Estimates;
use crate::refit::{Accepted, Amplitude};
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
    /// Draws of which the model could not be solved; they are in no figure.
    pub failed: usize,
    /// What is drawn: table and key.
    pub sources: Vec<String>,
    /// Numbers that have a standard uncertainty.
    pub parameters: Vec<DrawnParameter>,
}

/// How one number scatters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DrawnParameter {
    /// Its name.
    pub name: String,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// Estimate from the data as they are.
    pub value: f64,
    /// Standard uncertainty by linear propagation.
    pub linear_std: f64,
    /// Standard deviation over the draws.
    pub std: f64,
    /// Probabilistically symmetric 95 % coverage interval over the draws.
    pub interval_95: [f64; 2],
    /// Standard deviation where one source alone is drawn, one per source.
    pub by_source: Vec<f64>,
}

impl MonteCarlo {
    /// How many draws have no solution, where there are any.
    pub(crate) fn warning(&self) -> Option<String> {
        let Self { failed, draws, .. } = self;
        (*failed > 0).then(|| format!("{failed} of {draws} draws of the data have no solution"))
    }
}

/// Probability in each tail of a coverage interval.
const TAIL: f64 = 0.025;

/// Solves the declared model of a case with `draws` data sets that might have been measured as well.
///
/// # Errors
///
/// [`Error::Case`] where the case declares no noise to draw from; what the fit of the data as they are
/// says, or that of the first draw where none can be solved.
pub fn monte_carlo(case: &Case, draws: usize) -> Result<MonteCarlo, Error> {
    let found = described(&*case.fit()?.estimates);
    let solved = |drawn: &Case| -> Result<Option<Vec<Number>>, Error> {
        Ok(Some(described(&*drawn.fit()?.estimates)))
    };
    scattered(case, draws, found, solved)
}

/// The same of the model that a loop ended with: declared parameters and the amplitudes of the
/// accepted effects. What was chosen stays chosen.
pub(crate) fn monte_carlo_of_loop(
    case: &Case,
    (closure, estimates): (&Closure, &dyn Estimates),
    draws: usize,
) -> Result<MonteCarlo, Error> {
    let accepted = Accepted::of(case, closure)?;
    let amplitudes = accepted.amplitudes();
    let named = |a: &Amplitude| Number {
        name: a.name.clone(),
        unit: a.unit.clone(),
        value: a.value,
        std: Some(a.std),
    };
    let effects: Vec<Number> = amplitudes.iter().map(named).collect();
    let found = [described(estimates), effects.clone()].concat();
    let solved = |drawn: &Case| -> Result<Option<Vec<Number>>, Error> {
        let Some(refitted) = accepted.fitted_to(drawn)? else { return Ok(None) };
        let effects = effects.iter().zip(refitted.amplitudes);
        let effects = effects.map(|(named, value)| Number { value, ..named.clone() });
        Ok(Some(described(&*refitted.estimates).into_iter().chain(effects).collect()))
    };
    scattered(case, draws, found, solved)
}

/// A number with its name and uncertainty.
#[derive(Clone, Debug)]
struct Number {
    name: String,
    unit: String,
    value: f64,
    std: Option<f64>,
}

/// The numbers that describe a case.
fn described(estimates: &dyn Estimates) -> Vec<Number> {
    let number = |p: crate::estimated::Estimated| Number {
        name: p.name,
        unit: p.unit.to_owned(),
        value: p.value,
        std: p.std,
    };
    estimates.parameters().into_iter().map(number).collect()
}

/// Scatter of what was found where the data are drawn anew, from all sources and from each alone.
fn scattered(
    case: &Case,
    draws: usize,
    found: Vec<Number>,
    solved: impl Fn(&Case) -> Result<Option<Vec<Number>>, Error> + Sync,
) -> Result<MonteCarlo, Error> {
    let uncertain = case.files.kind.uncertain;
    let refused = |problem| Err(Error::case(case.files.document.at_file(), problem));
    if uncertain.is_empty() {
        let message = format!("results of `{}` have no uncertainty to draw", case.kind);
        return refused(Problem::WrongValue { message });
    }
    let sources = drawn(uncertain, &case.files, 0);
    if sources.is_empty() {
        let key = format!("[noise] {}", keys(uncertain).join("`, `"));
        let purpose = "draws are taken from the noise that is declared, and none is";
        return refused(Problem::MissingKey { key, purpose });
    }
    let found: Vec<Number> =
        found.into_iter().filter(|number| number.std.is_some_and(|std| std > 0.0)).collect();
    let of_draw = |draw: u64, only: Option<usize>| -> Result<Option<Vec<f64>>, Error> {
        let sources = drawn(uncertain, &case.files, draw).into_iter().enumerate();
        let chosen = sources.filter(|(k, _)| only.is_none_or(|only| only == *k));
        let edits: Vec<_> = chosen.flat_map(|(_, source)| source.edits).collect();
        let Some(numbers) = solved(&case.with(&edits)?)? else { return Ok(None) };
        let value = |of: &Number| numbers.iter().find(|n| n.name == of.name).map(|n| n.value);
        Ok(found.iter().map(value).collect())
    };
    let all = |only: Option<usize>| -> Vec<Vec<f64>> {
        let draws = (0..draws as u64).into_par_iter();
        draws.filter_map(|draw| of_draw(draw, only).ok().flatten()).collect()
    };
    let whole = all(None);
    let failed = draws - whole.len();
    if whole.is_empty() {
        // Every draw has failed, the first as any.
        let message = "no draw of the data can be solved".to_owned();
        return of_draw(0, None).and(refused(Problem::WrongValue { message }));
    }
    let alone: Vec<Vec<Vec<f64>>> = match sources.len() {
        1 => vec![whole.clone()],
        n => (0..n).map(|k| all(Some(k))).collect(),
    };
    let parameters = found
        .into_iter()
        .enumerate()
        .map(|(k, Number { name, unit, value, std })| {
            let off = scatter(&whole, k, value, &unit);
            let by_source = alone.iter().map(|own| deviation(&scatter(own, k, value, &unit)));
            DrawnParameter {
                value,
                linear_std: std.unwrap_or(f64::NAN),
                std: deviation(&off),
                interval_95: [quantile(&off, TAIL), quantile(&off, 1.0 - TAIL)]
                    .map(|off| value + off),
                by_source: by_source.collect(),
                name,
                unit,
            }
        })
        .collect();
    let sources = sources.into_iter().map(|Source { name, .. }| name).collect();
    Ok(MonteCarlo { draws, failed, sources, parameters })
}

/// The k-th number of every draw less its value, ascending.
fn scatter(draws: &[Vec<f64>], k: usize, value: f64, unit: &str) -> Vec<f64> {
    let off = |drawn: f64| match unit {
        // Angles come round.
        "°" => (drawn - value + 180.0).rem_euclid(360.0) - 180.0,
        _ => drawn - value,
    };
    let mut all: Vec<f64> = draws.iter().map(|values| off(values[k])).collect();
    all.sort_by(f64::total_cmp);
    all
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
