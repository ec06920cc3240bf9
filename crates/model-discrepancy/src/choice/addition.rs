//! What is added to a selection, and whether it may stay.

use crate::algebra::system::{Estimate, System, rows_of};
use crate::choice::candidate::{Candidate, Source};
use crate::choice::score::Scored;
use crate::choice::selected::{Added, Selected, What};

/// Adds candidates and refits; false, and nothing changed, when the nested cost did not fall.
pub(crate) fn add(chosen: &mut Selected<'_>, keep: &[bool], candidates: &[&Scored]) -> bool {
    let mut system = chosen.system.clone();
    for judged in candidates {
        system = judged.candidate.added_to(&system);
    }
    let rows = rows_of(&system.model.declared().layout, keep);
    let start = system.warm_start(&chosen.estimate);
    let Ok(estimate) = system.fit(&rows, &start) else { return false };
    if cost(&system, &estimate, &rows) >= cost(&chosen.system, &chosen.estimate, &rows) {
        return false;
    }
    let Ok(estimate) = system.reweighed(&rows, estimate) else { return false };
    if !within_limits(&system, &estimate) {
        return false;
    }
    chosen.system = system;
    chosen.estimate = estimate;
    for judged in candidates {
        let what = what(&judged.candidate);
        chosen.added.push(Added { what, p_value: judged.test.p_value });
    }
    true
}

pub(crate) fn what(candidate: &Candidate) -> What {
    match &candidate.source {
        Source::Effect(active) => What::Effect(active.effect),
        Source::Empirical(e) => What::Empirical(e.covariate.clone(), e.shape.clone()),
    }
}

/// Whether every effect has a size that it can have.
pub(crate) fn within_limits(system: &System<'_>, at: &Estimate) -> bool {
    system.active.iter().all(|active| {
        let maximum = system.model.declared().effects[active.effect].maximum;
        maximum.is_none_or(|maximum| at.state.amplitudes[active.effect].amax() <= maximum)
    })
}

/// Sum of squared whitened residuals over `rows`.
pub(crate) fn cost(system: &System<'_>, at: &Estimate, rows: &[usize]) -> f64 {
    let layout = &system.model.declared().layout;
    let all = system.residuals(at);
    rows.iter().map(|&row| (all[row] / at.sigma(&layout.rows[row])).powi(2)).sum()
}
