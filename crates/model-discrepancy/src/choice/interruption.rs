//! A course that breaks off and goes on elsewhere: a pause, a collision, an instrument restarted.

use crate::algebra::drifts;
use crate::choice::shape::{Shape, constant, distinct_fitted};
use crate::count::count;
use crate::{Covariate, Layout};

/// Places of a break that are looked at first, evenly over the readings.
const COARSE: usize = 32;

/// Places of a break along `covariate`, one between each two successive values; none where it is
/// not a time: along a position a break is a matter of the part, and its smooth shapes go first.
pub(crate) fn breaks(layout: &Layout, covariate: &Covariate) -> Vec<f64> {
    if !covariate.is_course() {
        return Vec::new();
    }
    drifts::breaks(&distinct_fitted(layout, covariate))
}

/// The break at which `powers` is largest: a coarse search, then a fine one around its best.
pub(crate) fn strongest(breaks: &[f64], powers: impl Fn(&[f64]) -> Vec<f64>) -> Option<f64> {
    let best_of = |candidates: Vec<usize>| {
        let at: Vec<f64> = candidates.iter().map(|&i| breaks[i]).collect();
        let powers = powers(&at).into_iter().zip(candidates);
        powers.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i)
    };
    let spacing = breaks.len().div_ceil(COARSE).max(1);
    let coarse = best_of((spacing / 2..breaks.len()).step_by(spacing).collect())?;
    let around = (coarse + 1).saturating_sub(spacing)..(coarse + spacing).min(breaks.len());
    best_of(around.collect()).map(|i| breaks[i])
}

/// Two straight lines, one before and one after `at`, which is one of `breaks`.
///
/// Each break counts as a trial. In white noise neighbouring ones are so alike that the best of 93
/// is worth 30; noise that remembers breaks off more often.
pub(crate) fn interrupted(covariate: &Covariate, at: f64, breaks: &[f64]) -> Shape {
    let values = &covariate.values;
    let mean = values.iter().sum::<f64>() / count(values.len());
    let after = |value: f64| f64::from(u8::from(value > at));
    let unit = covariate.name.rsplit_once('_').map_or("unit", |(_, unit)| unit);
    let functions = vec![
        ("jump".to_owned(), values.iter().map(|v| after(*v)).collect()),
        (format!("per {unit}"), values.iter().map(|v| v - mean).collect()),
        (format!("per {unit} after it"), values.iter().map(|v| after(*v) * (v - at)).collect()),
        constant(covariate),
    ];
    Shape { name: interruption_name(at), functions, tried: count(breaks.len()) }
}

/// Name of [`interrupted`].
pub(crate) fn interruption_name(at: f64) -> String {
    format!("interrupted at {at}")
}
