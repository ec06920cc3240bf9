//! Effects that move one observation, without a block of groups.

use nalgebra::{DMatrix, DVector};

use crate::Scope;
use crate::algebra::system::{Estimate, System};
use crate::choice::beside::Beside;
use crate::choice::one_observation::{ObservationRows, SeenLocal};
use crate::count::count;
use crate::levels::MASKED_AMONG;
use crate::noise::linear::Linear;
use crate::tests::f_test::f_test_of;

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
    pub(super) fn ids(&self, left_out: &[bool]) -> Vec<&str> {
        let mut ids = Vec::new();
        let there = |one: &&One| one.is_seen && !left_out[one.group];
        for one in self.effects.iter().filter(there) {
            if !ids.contains(&one.id.as_str()) {
                ids.push(one.id.as_str());
            }
        }
        ids
    }

    /// Whether one of them may be significant at `alpha` without some groups, or two that hide each
    /// other are looked for.
    pub(super) fn may_pass(&self, beside: &Beside, left_out: &[bool], alpha: f64) -> bool {
        let ids = self.ids(left_out);
        let mut families = vec![Family::default(); ids.len()];
        for (id, seen) in self.seen(beside, left_out) {
            if let Some(family) = ids.iter().position(|known| *known == id) {
                families[family].add(seen);
            }
        }
        let all = families.iter().map(|family| family.members).sum();
        families.iter().any(|family| family.may_pass(beside, alpha)) || MASKED_AMONG.contains(&all)
    }

    /// Each that is seen without some groups, by its id.
    fn seen<'s>(
        &'s self,
        beside: &'s Beside,
        left_out: &'s [bool],
    ) -> impl Iterator<Item = (&'s str, Seen)> {
        let data = beside.data(false);
        self.effects.iter().filter(|one| !left_out[one.group]).filter_map(move |one| {
            let held = beside.held(&one.directions.transpose(), false);
            let local = SeenLocal::of(&one.tangent, &held.transpose())?;
            let residual = &one.residual - held.tr_mul(&data);
            let explained = local.explained(&one.tangent, &residual);
            let seen = Seen { directions: local.directions(), explained };
            (beside.rows > beside.directions[0] + seen.directions).then_some((&one.id[..], seen))
        })
    }

    /// The p-value of each of [`Single::seen`].
    #[cfg(test)]
    pub(super) fn p_values(&self, beside: &Beside, left_out: &[bool]) -> Vec<f64> {
        self.seen(beside, left_out).filter_map(|(_, seen)| seen.p_value(beside)).collect()
    }
}

/// What is seen of an effect.
#[derive(Clone, Copy)]
struct Seen {
    directions: usize,
    explained: f64,
}

impl Seen {
    fn p_value(&self, beside: &Beside) -> Option<f64> {
        let (square, system) = (beside.squares[0], beside.directions[0]);
        let test = f_test_of(self.explained, self.directions, square, beside.rows, system);
        test.map(|test| test.p_value)
    }
}

/// Effects of one id.
#[derive(Clone, Default)]
struct Family {
    members: usize,
    /// The strongest of each number of directions: of as many, what explains most has the smallest
    /// p-value.
    strongest: Vec<Seen>,
}

impl Family {
    fn add(&mut self, seen: Seen) {
        self.members += 1;
        match self.strongest.iter_mut().find(|known| known.directions == seen.directions) {
            Some(known) => known.explained = known.explained.max(seen.explained),
            None => self.strongest.push(seen),
        }
    }

    fn may_pass(&self, beside: &Beside, alpha: f64) -> bool {
        let level = alpha / count(self.members);
        let mut p_values = self.strongest.iter().filter_map(|seen| seen.p_value(beside));
        p_values.any(|p_value| p_value <= level)
    }
}
