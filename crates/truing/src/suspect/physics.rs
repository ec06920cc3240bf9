//! What the loop's physics makes of a case, worked out once.

use model_discrepancy::{Closure, GROUP, Remaining, SCATTER, Step, Verdict};

use super::hypothesis::{Hypothesis, Proof};
use super::misfit::Misfit;
use super::search::{Found, Plain, Trials, is_evident};
use super::typed::SETTING;
use super::yardstick::Yardstick;
use crate::Case;
use crate::carry::EMPIRICAL;
use crate::count::count;
use crate::settled::{Settled, settled};

/// Physics loses to a mistake that is like it in size only where it leaves this much more.
const PHYSICS_LEAVES: f64 = 1.5;
/// It loses to a mistake that it imitates, where it leaves as much: the mistake has no free
/// parameter.
const PHYSICS_IMITATES: f64 = 0.9;
/// An amplitude that was looked for among dozens takes so much of χ² with it, of noise alone; of few
/// readings that is more than the tenth above, and never a sign that physics says more.
const TAKEN_BY_CHANCE: f64 = 10.0;
/// Share of the misfit below which physics leaves less, however few readings there are.
const LEAST_IMITATED: f64 = 0.7;
/// The same where physics needs effects more than a number of `case.toml` that nobody is free to choose.
const LEAST_IMITATED_BY_SETTING: f64 = 0.5;
/// Share of what a mistake leaves that physics leaves at most where it is as good.
const AS_WELL: f64 = 1.1;
/// Only where the misfit is so many standard uncertainties of an amplitude: a sound amplitude
/// equals one that a list of some ten mistakes has, within two uncertainties, once in eight.
const IMITATION: f64 = 300.0;
/// The same for a number of `case.toml`, where physics needs an effect more: an amplitude as large as
/// the number itself, a ball off by its radius or a head by its weight, is hardly ever sound.
const IMITATION_OF_SETTING: f64 = 60.0;
/// The same for what physics needs two effects for, which are one mistake.
const IMITATION_BY_TWO: f64 = 30.0;
/// The same for readings put to other places: an amplitude that is the way between two of them to so many standard
/// uncertainties is that way.
const IMITATION_OF_LABELS: f64 = 3000.0;
/// Mistakes that may be as small as physics.
const MILD: [&str; 6] =
    ["input:clock", "input:row-shift", LABELS, "input:saturation", "input:stuck", SETTING];
const LABELS: &str = "input:labels";
/// Significance above which something along a covariate is no part of scatter a hundred times the noise.
const HARDLY_SHOWS: f64 = 1e-6;
/// The condition that follows the rows.
const ORDER: &str = "order";
/// Share of a misfit that physics leaves at most where it explains it.
const EXPLAINED: f64 = 0.5;
/// Mistakes closed with physics beside them, at most: each closes a loop.
const MOST_CLOSED: usize = 4;
/// Factor that a mistake beside physics takes off the misfit.
const HELPS: f64 = 1.3;
/// The same where physics alone explains the case: then the mistake must be the larger part.
const HELPS_MOST: f64 = 3.0;

/// Whether a step is an effect, and no correction whose cause nobody knows.
fn has_a_cause(step: &Step) -> bool {
    !step.effect.starts_with(EMPIRICAL)
}

/// How physics stands beside a mistake.
pub(super) enum Contest {
    /// It explains the case better.
    Won,
    /// It explains no more; this is what it makes of the case without the mistake.
    Tied(Box<Physics>),
    /// It leaves clearly more, or is the less likely.
    Lost,
}

/// The loop closed on a case with nothing carried to it.
pub(super) struct Physics(Option<Settled>);

impl Physics {
    pub(super) fn of(case: &Case) -> Self {
        let options = case.loop_settings.options();
        let close = |prepared| settled(prepared, &options).ok().map(|(settled, _)| settled);
        Self(case.measured.prepare().ok().and_then(close))
    }

    /// Mistakes that may be there beside physics.
    pub(super) fn helping(trials: &Trials, plain: &Plain) -> Vec<Found> {
        trials.helping(plain, HELPS, MOST_CLOSED)
    }

    pub(super) fn closed(self) -> Option<Settled> {
        self.0
    }

    fn closure(&self) -> Option<&Closure> {
        self.0.as_ref().map(|settled| &settled.closure)
    }

    fn left(&self) -> Option<f64> {
        self.closure().map(|closure| closure.after.train_rms)
    }

    fn steps(&self) -> usize {
        self.closure().map_or(0, |closure| closure.steps.len())
    }

    /// Steps before the first correction without a cause, and what these leave: such a correction
    /// explains anything beside any change.
    fn by_name(&self) -> Option<(usize, f64)> {
        let closure = self.closure()?;
        let named = closure.steps.iter().take_while(|step| has_a_cause(step)).count();
        let left = match named {
            n if n == closure.steps.len() => closure.after.train_rms,
            0 => closure.before.train_rms,
            n => closure.steps[n - 1].train_rms,
        };
        Some((named, left))
    }

    fn amplitudes(&self) -> usize {
        self.closure().map_or(0, |c| c.steps.iter().map(|step| step.parameters.len()).sum())
    }

    /// Share of what is left with a mistake mended that this must leave to be no better.
    fn imitates(&self, after_it: &Self, dof: usize, least: f64) -> f64 {
        let more = self.amplitudes().saturating_sub(after_it.amplitudes());
        let by_chance = TAKEN_BY_CHANCE * count(more) / count(dof.max(1));
        (1.0 - by_chance).max(0.0).sqrt().clamp(least, PHYSICS_IMITATES)
    }

    pub(super) fn is_explained(&self) -> bool {
        let sound = [Verdict::NothingMissing, Verdict::Explained];
        self.closure().is_some_and(|closure| sound.contains(&closure.verdict))
    }

    /// χ² per degree of freedom of what it leaves, where that goes with nothing beyond what chance may show.
    pub(super) fn only_scatters(&self) -> Option<f64> {
        let closure = self.closure()?;
        let is_scatter =
            |left: &Remaining| left.covariate == SCATTER || left.p_value > HARDLY_SHOWS;
        let only = closure.remaining.iter().all(is_scatter);
        closure.after.chi2_per_dof.filter(|_| only && closure.steps.iter().all(has_a_cause))
    }

    /// Whether it says of some readings that they lie apart from the others: those of one group, or at one value of a
    /// condition.
    pub(super) fn sets_some_apart(&self) -> bool {
        let of_group = |closure: &Closure| closure.remaining.iter().any(|r| r.covariate == GROUP);
        let is_of_condition = |step: &Step| {
            let along = step.effect.strip_prefix(EMPIRICAL);
            along.is_some_and(|covariate| covariate != ORDER)
        };
        let takes_most = |closure: &Closure| {
            closure.after.train_rms <= EXPLAINED * closure.before.train_rms
                && closure.steps.iter().any(is_of_condition)
        };
        self.closure().is_some_and(|closure| of_group(closure) || takes_most(closure))
    }

    /// Whether it says anything: what free parameters take up it does not see.
    pub(super) fn has_names(&self) -> bool {
        self.steps() > 0
    }

    pub(super) fn has_names_alone(&self) -> bool {
        self.closure().is_some_and(|closure| closure.steps.iter().all(has_a_cause))
    }

    /// Whether what it names takes most of the misfit.
    pub(super) fn names_most(&self) -> bool {
        let named = self.closure().zip(self.by_name());
        named.is_some_and(|(closure, (_, left))| left <= EXPLAINED * closure.before.train_rms)
    }

    /// Whether it takes most of the misfit, and what it leaves is not gross still: of tables that do not
    /// belong together it takes little, or what goes with the order of their rows.
    pub(super) fn takes_most(&self, yardstick: &Yardstick) -> bool {
        let gross = yardstick.unmatched.max(yardstick.gross) * yardstick.spread;
        self.closure().is_some_and(|Closure { before, after, .. }| {
            after.train_rms <= EXPLAINED * before.train_rms && after.train_rms < gross
        })
    }

    /// How it stands beside a mistake that explains everything alone.
    pub(super) fn beside_alone(&self, case: &Case, found: &Found, before: &Misfit) -> Contest {
        // Straight lines between readings average their noise: a clock gains √2 by that alone.
        let gain = found.after.map_or(0.0, |after| before.gain(&after));
        if found.named.is_unphysical() && gain >= PHYSICS_LEAVES {
            return Contest::Lost;
        }
        let after_it = case.with(&found.named.edits).ok().map(|mended| Self::of(&mended));
        let Some(after_it) = after_it else { return Contest::Won };
        let Some((named, mended)) = after_it.by_name() else { return Contest::Won };
        // A number that is free takes up as much as an effect, and less than a correction without a cause.
        let is_free = found.named.effect == SETTING;
        let left = if is_free { self.by_name().map(|(_, left)| left) } else { self.left() };
        let Some(left) = left else { return Contest::Lost };
        let is_simpler = found.named.is_of_settings() && named < self.steps();
        let least = match found.named.effect {
            LABELS => IMITATION_OF_LABELS,
            _ if is_simpler => IMITATION_OF_SETTING,
            _ => IMITATION,
        };
        let is_exact = found.after.is_some_and(|after| before.significance(&after) >= least);
        // What is free without a table explains what physics does.
        let is_mild = found.named.effect != LABELS && MILD.contains(&found.named.effect)
            || found.named.omits_a_file();
        // Two readings that are each other's: physics needs a bad reading for either. What is left
        // out frees as much as an effect does.
        let omits = found.named.omits_a_file() || found.rivals.iter().any(Hypothesis::omits_a_file);
        let is_of_two = found.named.effect == LABELS || omits;
        let is_fewer = is_of_two && named + 2 <= self.steps();
        let is_of_both =
            found.after.is_some_and(|after| before.significance(&after) >= IMITATION_BY_TWO);
        let dof = found.after.map_or(0, |after| after.dof);
        let imitated = if is_simpler { LEAST_IMITATED_BY_SETTING } else { LEAST_IMITATED };
        let is_equal = left >= self.imitates(&after_it, dof, imitated) * mended;
        if left >= PHYSICS_LEAVES * mended
            || is_equal && (!is_mild && is_exact || is_fewer && is_of_both)
        {
            Contest::Lost
        } else if found.named.is_of_an_end()
            && found.named.proof == Proof::Fit
            && self.has_names_alone()
            && left <= AS_WELL * mended
        {
            // It explains what the mistake would leave out, too.
            Contest::Won
        } else if is_equal && !is_free && after_it.is_explained() && named < self.steps() {
            Contest::Tied(Box::new(after_it))
        } else {
            Contest::Won
        }
    }

    /// Its steps that are not needed once a mistake is mended, as rivals of that.
    pub(super) fn tie(&mut self, found: &Found, after_it: &Self) {
        let needed: Vec<_> = after_it.closure().into_iter().flat_map(|c| &c.steps).collect();
        let Some(settled) = &mut self.0 else { return };
        let is_needed = |step: &Step| {
            needed.iter().any(|other| other.effect == step.effect && other.subject == step.subject)
        };
        let mistakes = std::iter::once(&found.named).chain(&found.rivals);
        // One mistake may have happened in several ways that read alike.
        let mut labels: Vec<String> = Vec::new();
        for label in mistakes.map(Hypothesis::label) {
            if !labels.contains(&label) {
                labels.push(label);
            }
        }
        let input = format!("look at the input first: {}", found.named.description);
        for step in settled.closure.steps.iter_mut().filter(|step| !is_needed(step)) {
            step.indistinguishable_from.extend(labels.iter().cloned());
            step.rivals.extend(labels.iter().cloned());
            step.separate_by = Some(match step.separate_by.take() {
                Some(known) => format!("{known}; or {input}"),
                None => input.clone(),
            });
        }
    }

    /// The mistake beside which physics explains what it does not explain alone, or explains with
    /// less; with the loop closed on the case so mended.
    pub(super) fn beside(
        &self,
        case: &Case,
        helping: Vec<Found>,
        plain: &Plain,
    ) -> Option<(Found, Self)> {
        let left = self.left()?;
        let mut best: Option<(Found, Self, f64)> = None;
        let gain = |found: &Found| found.after.map_or(0.0, |after| plain.misfit.gain(&after));
        let helping =
            helping.into_iter().filter(|found| !self.is_explained() || gain(found) >= HELPS_MOST);
        for found in helping {
            let Ok(mended) = case.with(&found.named.edits) else { continue };
            let closed = Self::of(&mended);
            let Some(leaves) =
                closed.left().filter(|_| closed.is_explained() && closed.has_names_alone())
            else {
                continue;
            };
            let dof = found.after.map_or(0, |after| after.dof);
            let is_better = left >= PHYSICS_LEAVES * leaves && is_evident(dof, left / leaves);
            let imitates = self.imitates(&closed, dof, LEAST_IMITATED);
            let is_simpler = closed.steps() < self.steps() && left >= imitates * leaves;
            let is_exact =
                found.after.is_some_and(|after| plain.misfit.significance(&after) >= IMITATION);
            let is_mild = MILD.contains(&found.named.effect);
            let wins = is_better || is_simpler && is_exact && !is_mild;
            if wins && best.as_ref().is_none_or(|(_, _, least)| leaves < *least) {
                best = Some((found, closed, leaves));
            }
        }
        best.map(|(found, closed, _)| (found, closed))
    }
}
