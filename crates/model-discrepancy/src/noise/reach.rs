//! How far noise remembers, judged where nothing that repeats is left.

use crate::count::count;

/// Largest distance, in visits, at which memory of the noise is looked for.
const MAX_LAG: usize = 20;

/// Standard errors from which on a correlation is no chance.
const CLEAR: f64 = 2.0;

/// Correlation above which readings are alike.
const ALIKE: f64 = 0.1;

/// Largest correlation of neighbours that is taken for memory.
const MAX_CORRELATION: f64 = 0.95;

/// Least share of independent values that noise with memory is taken to have.
const MIN_INDEPENDENT: f64 = 0.05;

/// How far noise remembers.
pub(crate) struct Memory {
    /// Distance within which readings are alike.
    pub(crate) reach: usize,
    /// Share of the readings that are independent.
    pub(crate) share: f64,
}

impl Memory {
    /// From readings about the means of their places.
    pub(crate) fn of(series: &[Vec<f64>]) -> Self {
        let n: usize = series.iter().flatten().filter(|v| **v != 0.0).count();
        let square: f64 = series.iter().flatten().map(|v| v * v).sum();
        if n == 0 || square <= 0.0 {
            return Self { reach: 1, share: 1.0 };
        }
        let n = count(n);
        let correlation = |lag: usize| {
            let products = series.iter().flat_map(|one| one.iter().zip(one.iter().skip(lag)));
            products.map(|(a, b)| a * b).sum::<f64>() / square
        };
        let longest = series.iter().map(Vec::len).max().unwrap_or(0);
        let correlations: Vec<f64> = (1..=MAX_LAG.min(longest / 4)).map(correlation).collect();
        let by_chance = CLEAR / n.sqrt();
        let alike = correlations.iter().take_while(|c| **c > by_chance.max(ALIKE)).count();
        // What chance alone makes of a squared correlation is taken off.
        let sum: f64 = correlations.iter().map(|c| (c * c - 1.0 / n).max(0.0)).sum();
        let neighbours = correlations.first().copied().unwrap_or(0.0);
        let phi = if neighbours > by_chance { surely_below(neighbours, n) } else { 0.0 };
        let share = (1.0 / (1.0 + 2.0 * sum)).min((1.0 - phi * phi) / (1.0 + phi * phi));
        Self { reach: 1 + alike, share: share.max(MIN_INDEPENDENT) }
    }
}

/// A correlation of neighbours that the true one is surely not above: two standard errors, and the
/// bias of a short series (Kendall 1954), added.
fn surely_below(correlation: f64, n: f64) -> f64 {
    let error = ((1.0 - correlation * correlation).max(0.0) / n).sqrt();
    (correlation + CLEAR * error + (1.0 + 3.0 * correlation) / n).min(MAX_CORRELATION)
}
