//! A drift that comes to rest, found by looking for its time constant.

use crate::algebra::looked_through::{FALSE_ALARM, LookedThrough};
use crate::count::count;
use crate::{Effect, Model, State, whole_tangent};

/// Time constants that are tried, as shares of the series: from a few readings to a quarter of it,
/// beyond which the course is a straight line with a bend, and a drift is called so.
const SHARES: [f64; 6] = [0.03, 0.05, 0.08, 0.12, 0.18, 0.27];

/// Steps of the time constant once one is found, either way.
const REFINED: [f64; 5] = [1.2, 1.1, 1.05, 1.02, 1.01];

/// A first-order course, `1 − exp(−t/τ)`: a spindle or a stand that warms up, a pad that sets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settling {
    /// In the unit in which time is counted.
    time_constant: f64,
    searched: usize,
}

impl Settling {
    /// How far it has come at each time since its start.
    #[must_use]
    pub fn course(&self, elapsed: &[f64]) -> Vec<f64> {
        elapsed.iter().map(|t| -(-t / self.time_constant).exp_m1()).collect()
    }

    /// The effect for a drift that goes on evenly; its amplitudes, in units of their own, are what it
    /// comes to in the end.
    #[must_use]
    pub fn effect(&self, even: &Effect, time_unit: &str, unit: &str, report_factor: f64) -> Effect {
        let mut effect = even.clone();
        let subject = even.subject.as_ref().map_or_else(String::new, |s| format!("{s}, "));
        effect.subject = Some(format!("{subject}settling"));
        effect.description = format!(
            "{} and comes to rest: 1 − exp(−t/τ), τ = {} {time_unit}",
            even.description, self.time_constant
        );
        effect.searched = self.searched;
        for parameter in &mut effect.parameters {
            unit.clone_into(&mut parameter.unit);
            parameter.report_factor = report_factor;
        }
        effect
    }
}

/// The time constant with which a drift takes most of the residual of a model at `at`, a solution
/// of its declared part; `None` where white noise might show one as clear.
///
/// `drift` is the effect that goes on evenly, `elapsed` what its amplitudes are multiplied by: the
/// time since the start of the series, one value per observation.
#[must_use]
pub fn clearest_settling(
    model: &dyn Model,
    at: &State,
    drift: usize,
    elapsed: &[f64],
) -> Option<Settling> {
    let span = elapsed.iter().copied().fold(0.0, f64::max);
    if !(span > 0.0 && span.is_finite()) || elapsed.iter().any(|t| *t < 0.0) {
        return None;
    }
    let residual = LookedThrough::of(model, at);
    let rows = &model.declared().layout.rows;
    let observations: Vec<usize> =
        residual.rows().iter().map(|&row| rows[row].observation).collect();
    let even = whole_tangent(model, at, drift).select_rows(residual.rows());
    let searched = SHARES.len();
    let explained = |time_constant: f64| {
        let settling = Settling { time_constant: three_digits(time_constant), searched };
        let course = settling.course(elapsed);
        let mut columns = even.clone();
        for (mut row, &observation) in columns.row_iter_mut().zip(&observations) {
            // What has no time, as prior knowledge, no drift moves.
            let passed = elapsed.get(observation).copied().filter(|t| *t > 0.0);
            row *= passed.map_or(0.0, |t| course[observation] / t);
        }
        let left = residual.left_of(residual.whitened(columns));
        Some((residual.explained(&left)?, left.ncols(), settling))
    };
    let all = SHARES.iter().filter_map(|share| explained(share * span));
    let (mut most, columns, mut best) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
    for step in REFINED {
        for factor in [1.0 / step, step] {
            let moved = explained(best.time_constant * factor);
            if let Some((more, _, settling)) = moved.filter(|(more, ..)| *more > most) {
                (most, best) = (more, settling);
            }
        }
    }
    (residual.p_value(most, columns) * count(searched) <= FALSE_ALARM).then_some(best)
}

/// Rounded to three significant digits, as it is printed.
fn three_digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
