//! What the loop would say once planned measurements are made, by simulation.

use std::fmt;

use nalgebra::DVector;
use rayon::prelude::*;

use crate::algebra::silent::silent_components;
use crate::algebra::system::{Estimate, System, rows_of};
use crate::answer::estimate::noise_level;
use crate::answer::separation::all_fitted;
use crate::choice::candidate::{estimability, label};
use crate::count::count;
use crate::model::moved::{Moved, normally};
use crate::noise::linear::Linear;
use crate::{Closure, Covariate, Effect, LoopError, Model, Options, close_loop};

/// Simulated data sets: with one of forty missed, the share is above 0.90 with a probability of 0.92.
const DATA_SETS: usize = 40;
/// Data sets closed before it is asked whether too many are missed.
const AT_ONCE: usize = 8;

/// Measurements that are planned, in a model of the measured ones and these.
#[derive(Clone, Copy)]
pub struct Foreseen<'a> {
    /// The model, with any readings in the rows of what is planned.
    pub model: &'a dyn Model,
    /// As for [`close_loop`].
    pub covariates: &'a [Covariate],
    /// As for [`close_loop`].
    pub options: &'a Options,
    /// Rows of what is planned, of the layout.
    pub planned: &'a [usize],
}

impl fmt::Debug for Foreseen<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Foreseen").field("planned", &self.planned).finish_non_exhaustive()
    }
}

impl Foreseen<'_> {
    /// How often the loop names `truth` and not each of `rivals` for it, if `truth` is right.
    ///
    /// `effects` are there, `truth` among them, each called by its id with the subject in brackets: as
    /// large as what was measured says, so it stays as it is, and what is planned is what these would
    /// make of it, with white noise. Data sets are simulated until in more than `missed_share` of all
    /// any rival is left; `None` where an effect is not in the model or not to be seen in what was measured.
    ///
    /// # Errors
    ///
    /// As [`close_loop`], for what was measured.
    pub fn told_apart(
        &self,
        effects: &[&str],
        (truth, rivals): (&str, &[&str]),
        missed_share: f64,
    ) -> Result<Option<Vec<f64>>, LoopError> {
        let Some((system, at, factor)) = self.as_measured(effects)? else { return Ok(None) };
        let expected = system.residuals(&at);
        // Repetitions take back names, not rivals.
        let options = Options { nested: false, ..self.options.clone() };
        let rows = &self.model.declared().layout.rows;
        let told = |set: usize| {
            let mut offsets = DVector::zeros(rows.len());
            for (n, &row) in self.planned.iter().enumerate() {
                let normal = normally(set * self.planned.len() + n);
                offsets[row] = factor * at.sigma(&rows[row]) * normal - expected[row];
            }
            let moved = Moved::by(self.model, offsets);
            let closed = close_loop(&moved, self.covariates, &options);
            let is_told = |rival: &&str| closed.as_ref().is_ok_and(|c| names(c, truth, rival));
            rivals.iter().map(is_told).collect::<Vec<bool>>()
        };
        let mut sets: Vec<Vec<bool>> = Vec::new();
        let missed = |sets: &[Vec<bool>]| sets.iter().filter(|told| told.contains(&false)).count();
        while sets.len() < DATA_SETS && count(missed(&sets)) <= missed_share * count(DATA_SETS) {
            let next = sets.len()..(sets.len() + AT_ONCE).min(DATA_SETS);
            sets.par_extend(next.into_par_iter().map(told));
        }
        let share = |rival: usize| {
            count(sets.iter().filter(|told| told[rival]).count()) / count(sets.len())
        };
        Ok(Some((0..rivals.len()).map(share).collect()))
    }

    /// The system of the effects fitted to what was measured, and the factor of its noise.
    fn as_measured(
        &self,
        effects: &[&str],
    ) -> Result<Option<(System<'_>, Estimate, f64)>, LoopError> {
        let declared = self.model.declared();
        let layout = &declared.layout;
        let mut keep = all_fitted(self.model);
        for &row in self.planned {
            keep[layout.observations[layout.rows[row].observation]] = false;
        }
        let rows = rows_of(layout, &keep);
        let mut system = System::declared(self.model);
        let mut at = system.fit_first(&rows).map_err(LoopError::declared)?;
        let silent = silent_components(&system, &at, &rows);
        for name in effects {
            let is_it = |e: &Effect| label(&e.id, e.subject.as_deref()) == *name;
            let Some(effect) = declared.effects.iter().position(is_it) else { return Ok(None) };
            let lin = Linear::of(&system, &at, &keep, &silent);
            let Some(seen) = estimability(self.model, effect, &at, &lin, &lin.basis).candidate()
            else {
                return Ok(None);
            };
            system = seen.added_to(&system);
            at = system.fit(&rows, &system.warm_start(&at)).map_err(LoopError::declared)?;
        }
        let factor = noise_level(&system, &at, &rows).variance_factor.sqrt();
        Ok(Some((system, at, factor)))
    }
}

/// Whether an effect is named, and not its rival for it.
fn names(closure: &Closure, truth: &str, rival: &str) -> bool {
    closure.steps.iter().any(|step| {
        let accepted = label(&step.effect, step.subject.as_deref());
        let is_named = |name: &str| name == accepted || step.rivals.iter().any(|r| r == name);
        is_named(truth) && !is_named(rival)
    })
}
