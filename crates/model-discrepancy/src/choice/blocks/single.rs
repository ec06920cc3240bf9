//! Effects that move one observation, without a block of groups.

use nalgebra::{DMatrix, DVector};

use crate::Scope;
use crate::algebra::system::{Estimate, System};
use crate::choice::beside::Beside;
use crate::choice::one_observation::{BesideLocal, ObservationRows, SeenLocal};
use crate::count::count;
use crate::levels::MASKED_AMONG;
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
    /// Whether anything of it is seen with all groups.
    is_seen: bool,
}

impl Single {
    pub(super) fn of(
        banned: &[usize],
        (system, at): (&System<'_>, &Estimate),
        lin: &Linear<'_>,
        clean: &DVector<f64>,
    ) -> Self {
        let layout = lin.layout;
        let readings = ObservationRows::of(lin);
        let effects = &system.model.declared().effects;
        let is_open = |e: &usize| !system.has_effect(*e) && !banned.contains(e);
        let one = |e: usize| {
            let Scope::Observation(observation) = effects[e].scope else { return None };
            let values = system.model.tangent(&at.state, e);
            let (rows, tangent) = readings.whitened(observation, &values)?;
            let directions = lin.basis.rows(rows);
            Some(One {
                id: effects[e].id.clone(),
                group: layout.observations[observation],
                is_seen: SeenLocal::of(&tangent, &directions).is_some(),
                tangent,
                directions,
                residual: clean.select_rows(rows),
            })
        };
        Self { effects: (0..effects.len()).filter(is_open).filter_map(one).collect() }
    }

    /// Ids of those that are seen without some groups.
    pub(super) fn ids(&self, left_out: &[usize]) -> Vec<&str> {
        let mut ids = Vec::new();
        let there = |one: &&One| one.is_seen && !left_out.contains(&one.group);
        for one in self.effects.iter().filter(there) {
            if !ids.contains(&one.id.as_str()) {
                ids.push(one.id.as_str());
            }
        }
        ids
    }

    /// Whether one of them may be significant at `alpha` without some groups, or two that hide each
    /// other are looked for.
    pub(super) fn may_pass(&self, beside: &Beside, left_out: &[usize], alpha: f64) -> bool {
        let p_values = self.p_values(beside, left_out);
        let passes = |members: &Vec<f64>| {
            members.iter().any(|p_value| *p_value <= alpha / count(members.len()))
        };
        p_values.iter().any(passes) || MASKED_AMONG.contains(&p_values.iter().map(Vec::len).sum())
    }

    /// The p-value of each that is seen without some groups, by id.
    pub(super) fn p_values(&self, beside: &Beside, left_out: &[usize]) -> Vec<Vec<f64>> {
        let data = beside.data(false);
        let system = BesideLocal {
            rows: beside.rows,
            directions: beside.directions[0],
            square: beside.squares[0],
        };
        let ids = self.ids(left_out);
        let mut p_values = vec![Vec::new(); ids.len()];
        for one in self.effects.iter().filter(|one| !left_out.contains(&one.group)) {
            let directions = beside.held(&one.directions.transpose(), false).transpose();
            let Some(seen) = SeenLocal::of(&one.tangent, &directions) else { continue };
            let residual = &one.residual - &directions * &data;
            let Some(test) = seen.test(&one.tangent, &residual, &system) else { continue };
            if let Some(family) = ids.iter().position(|id| *id == one.id) {
                p_values[family].push(test.p_value);
            }
        }
        p_values
    }
}
