//! Effects that were chosen.

use crate::algebra::system::{Estimate, System};
use crate::choice::candidate::{Candidate, Source};
use crate::{Model, Pass};

/// A system as chosen on some groups.
#[derive(Clone)]
pub(crate) struct Selected<'a> {
    pub(crate) system: System<'a>,
    pub(crate) estimate: Estimate,
    pub(crate) added: Vec<Added>,
    /// For the report, where it is asked for.
    pub(crate) passes: Vec<Pass>,
    /// Effects that the declared model's design cannot see, with the share absorbed.
    pub(crate) not_estimable: Vec<(usize, f64)>,
}

impl Selected<'_> {
    /// The same of `model`, on which it was chosen.
    pub(crate) fn on(self, model: &dyn Model) -> Selected<'_> {
        let System { active, empirical, .. } = self.system;
        let Self { estimate, added, passes, not_estimable, .. } = self;
        let system = System { model, active, empirical };
        Selected { system, estimate, added, passes, not_estimable }
    }
}

/// Something that was added.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Added {
    pub(crate) what: What,
    pub(crate) p_value: f64,
}

/// What was added.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum What {
    /// Index into the catalogue.
    Effect(usize),
    /// Covariate and shape.
    Empirical(String, String),
}

/// What a candidate would add.
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
