//! Further readings that would split what a positioning run confuses.

use model_discrepancy::{Covariate, Quantity};

use crate::axis_reading::{Approach, AxisReading};
use crate::missing::axis_run::AxisRun;

/// How much warmer an axis is that has run for a shift; it need not be that much.
const WARMER_K: f64 = 5.0;

/// A run that goes on with further readings; the values of their deviations do not matter.
pub(super) struct Longer {
    /// What to do, in the imperative.
    pub(super) text: &'static str,
    /// Those of the run, and then the further ones.
    pub(super) readings: Vec<AxisReading>,
    /// The cycle of each, where they are known.
    pub(super) cycles: Option<Vec<usize>>,
    /// One value for each.
    pub(super) covariates: Vec<Covariate>,
}

/// Further readings that the user could take, the cheapest first.
pub(super) fn proposals(run: &AxisRun<'_>) -> Vec<Longer> {
    let n = run.readings.len();
    let back: Vec<usize> = (0..n).rev().collect();
    let again: Vec<usize> = (0..n).collect();
    let same = |r: &AxisReading| r.approach;
    let mut all = Vec::new();
    if let Some(turned) = from_the_other_side(run) {
        let text = "come to every target from the other side, too, on the way back";
        all.push(longer(text, run, &back, |_| Some(turned), |t| t));
    }
    let text = "read every target again in the opposite order, each from the same side as before";
    all.push(longer(text, run, &back, same, |t| t));
    if run.covariates.iter().any(|c| c.quantity == Quantity::Temperature) {
        let text = "read every target again once the temperatures are those of the first readings";
        all.push(longer(text, run, &again, same, |t| t));
        let text = "read every target again with all temperatures some kelvin higher";
        all.push(longer(text, run, &again, same, |t| t + WARMER_K));
    }
    all
}

/// The other side, where the axis came from one side alone.
fn from_the_other_side(run: &AxisRun<'_>) -> Option<Approach> {
    let first = run.readings.first()?.approach?;
    let is_one_sided = run.readings.iter().all(|r| r.approach == Some(first));
    is_one_sided.then_some(match first {
        Approach::Rising => Approach::Falling,
        Approach::Falling => Approach::Rising,
    })
}

/// The run and then readings `again` of it, one after the other at its mean pace, each from a side and at a
/// temperature as a function of what they were.
fn longer(
    text: &'static str,
    run: &AxisRun<'_>,
    again: &[usize],
    approach: impl Fn(&AxisReading) -> Option<Approach>,
    temperature: impl Fn(f64) -> f64,
) -> Longer {
    let further = again.iter().map(|&i| {
        let reading = &run.readings[i];
        let (name, approach) = (format!("{} again", reading.name), approach(reading));
        AxisReading { name, approach, deviation: 0.0, ..*reading }
    });
    let readings = run.readings.iter().cloned().chain(further).collect();
    let further = |covariate: &Covariate| {
        let values = &covariate.values;
        let mut all = values.clone();
        if AxisRun::is_time(covariate) {
            let first = values.iter().copied().fold(f64::INFINITY, f64::min);
            let last = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let step = (last - first) / crate::count(values.len().saturating_sub(1).max(1));
            all.extend((1..=again.len()).map(|k| last + step * crate::count(k)));
        } else if covariate.quantity == Quantity::Temperature {
            all.extend(again.iter().map(|&i| temperature(values[i])));
        } else {
            all.extend(again.iter().map(|&i| values[i]));
        }
        Covariate { values: all, ..covariate.clone() }
    };
    // The zero stays that of the last cycle.
    let cycles = run.cycles.map(|cycles| {
        let last = cycles.iter().max().copied().unwrap_or(0);
        cycles.iter().copied().chain(again.iter().map(|_| last)).collect()
    });
    Longer { text, readings, cycles, covariates: run.covariates.iter().map(further).collect() }
}
