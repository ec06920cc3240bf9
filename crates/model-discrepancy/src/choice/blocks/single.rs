//! Effects that move one observation, without a block of groups.

use nalgebra::{DMatrix, DVector};

use crate::Scope;
use crate::algebra::system::{Estimate, System};
use crate::choice::beside::Beside;
use crate::choice::blocks::left_in;
use crate::choice::context::Context;
use crate::choice::masked::may_be_masked;
use crate::choice::one_observation::{BesideLocal, SeenLocal};
use crate::count::count;
use crate::noise::linear::Linear;

/// Every effect that moves one observation.
pub(super) struct Single {
    effects: Vec<One>,
}

struct One {
    id: String,
    /// Of the observation.
    group: usize,
    /// Rows of the observation: the effect's, whitened, the system's directions, and what is left of
    /// the data.
    tangent: DMatrix<f64>,
    directions: DMatrix<f64>,
    residual: DVector<f64>,
}

/// By id, the p-value of each that is seen.
pub(super) struct Families(Vec<(String, Vec<f64>)>);

impl Single {
    pub(super) fn of(
        context: &Context<'_>,
        system: &System<'_>,
        at: &Estimate,
        lin: &Linear<'_>,
        clean: &DVector<f64>,
    ) -> Self {
        let layout = lin.layout;
        let mut of_observation = vec![Vec::new(); layout.observations.len()];
        for (i, &row) in lin.rows.iter().enumerate() {
            of_observation[layout.rows[row].observation].push(i);
        }
        let mut first_row = vec![usize::MAX; layout.observations.len()];
        for (row, r) in layout.rows.iter().enumerate() {
            first_row[r.observation] = first_row[r.observation].min(row);
        }
        let effects = &context.model.declared().effects;
        let is_open = |e: &usize| !system.has_effect(*e) && !context.banned.contains(e);
        let one = |e: usize| {
            let Scope::Observation(observation) = effects[e].scope else { return None };
            let rows = &of_observation[observation];
            let whole = system.model.tangent(&at.state, e);
            let first = first_row[observation];
            let mut tangent = DMatrix::zeros(rows.len(), whole.ncols());
            for (to, &i) in rows.iter().enumerate() {
                tangent.row_mut(to).copy_from(&(whole.row(lin.rows[i] - first) / lin.sigma[i]));
            }
            Some(One {
                id: effects[e].id.clone(),
                group: layout.observations[observation],
                tangent,
                directions: lin.basis.rows(rows),
                residual: clean.select_rows(rows),
            })
        };
        Self { effects: (0..effects.len()).filter(is_open).filter_map(one).collect() }
    }

    /// Without some groups.
    pub(super) fn families(&self, beside: &Beside, left_out: &[usize]) -> Families {
        let data = beside.data(false);
        let system = BesideLocal {
            rows: beside.rows,
            directions: beside.directions[0],
            square: beside.squares[0],
        };
        let mut families: Vec<(String, Vec<f64>)> = Vec::new();
        for one in self.effects.iter().filter(|one| !left_out.contains(&one.group)) {
            let directions = beside.held(&one.directions.transpose(), false).transpose();
            let Some(seen) = SeenLocal::of(&one.tangent, &directions) else { continue };
            let residual = left_in(&one.residual, &directions, &data);
            let Some(test) = seen.test(&one.tangent, &residual, &system) else { continue };
            match families.iter_mut().find(|(id, _)| *id == one.id) {
                Some((_, members)) => members.push(test.p_value),
                None => families.push((one.id.clone(), vec![test.p_value])),
            }
        }
        Families(families)
    }
}

impl Families {
    /// Whether one of them may be significant at `alpha`, or two that hide each other are looked for.
    pub(super) fn may_pass(&self, alpha: f64) -> bool {
        let passes = |(_, members): &(String, Vec<f64>)| {
            members.iter().any(|p_value| *p_value <= alpha / count(members.len()))
        };
        self.0.iter().any(passes) || may_be_masked(self.0.iter().map(|(_, m)| m.len()).sum())
    }

    /// The least p-value of each id, and of how many.
    #[cfg(test)]
    pub(super) fn least(&self) -> Vec<(f64, usize)> {
        let least = |p_values: &Vec<f64>| p_values.iter().copied().fold(1.0, f64::min);
        self.0.iter().map(|(_, p_values)| (least(p_values), p_values.len())).collect()
    }

    /// Whether effects of this id are among them.
    pub(super) fn has(&self, id: &str) -> bool {
        self.0.iter().any(|(known, _)| known == id)
    }

    /// How many ids there are.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }
}
