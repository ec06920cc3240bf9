//! What a design can see, before or without any finding.

use std::borrow::Cow;
use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::algebra::system::{System, rows_of};
use crate::answer::named_size::Simulation;
use crate::answer::separation::{Advice, Imitation, all_fitted};
use crate::choice::candidate::{Candidate, Estimability, Source, catalogue, classes, label};
use crate::choice::context::Context;
use crate::choice::detectable::{
    detectable_amplitudes, detectable_rms, local_detectable_amplitudes, local_detectable_rms,
    noncentrality, reported_observations,
};
use crate::choice::one_observation::{LocalEstimability, full_candidate, local_effects};
use crate::choice::score::{Candidates, ScorePass, Scored, Scoring, score_catalogue};
use crate::error::LoopError;
use crate::levels::CATALOGUE_SHARE;
use crate::model::validate::validate;
use crate::noise::linear::Linear;
use crate::tests::significance::Reach;
use crate::{Model, Options};

/// What the design sees of one effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Assessment {
    /// Catalogue id.
    pub effect: String,
    /// What it is about, where there is one candidate per thing.
    pub subject: Option<String>,
    /// One sentence for people.
    pub description: String,
    /// Share of its tangent that the declared model absorbs, 0 to 1.
    pub absorbed: f64,
    /// Minimal detectable size, or why there is none.
    pub sight: Visibility,
}

/// Whether the design sees an effect.
#[derive(Clone, Debug, PartialEq)]
pub enum Visibility {
    /// It would be found.
    Visible {
        /// Smallest amplitude of each parameter alone that the loop names 9 times in 10 at the noise of
        /// these data, in report units: name, value, unit. By simulation where there are at most
        /// [`MOST_SIMULATED`] rows, else what the F test alone finds.
        detectable: Vec<(String, f64, String)>,
        /// The same as rms of the effect over the observations, in the residual's unit.
        detectable_rms: f64,
        /// Effects with the same tangent.
        same_as: Vec<String>,
    },
    /// It would not.
    Hidden {
        /// Base parameters that absorb it; empty when it leaves no trace at all.
        aliased_with: Vec<String>,
        /// The measurement that would make it visible.
        separate_by: Option<String>,
    },
}

/// Most rows of a design on which the choice is simulated.
pub const MOST_SIMULATED: usize = 600;

/// Assesses every effect of the catalogue at the fitted declared model.
///
/// # Errors
///
/// As [`close_loop`](crate::close_loop).
pub fn assess(model: &dyn Model, options: &Options) -> Result<Vec<Assessment>, LoopError> {
    assess_those(model, options, |_| true)
}

/// [`assess`] of the effects whose id, with the subject in brackets where there is one, is `wanted`.
///
/// # Errors
///
/// As [`close_loop`](crate::close_loop).
pub fn assess_those(
    model: &dyn Model,
    options: &Options,
    wanted: impl Fn(&str) -> bool,
) -> Result<Vec<Assessment>, LoopError> {
    validate(model, &[])?;
    let keep = all_fitted(model);
    let system = System::declared(model);
    let rows = rows_of(&model.declared().layout, &keep);
    let at = system.fit_first(&rows).map_err(LoopError::declared)?;
    let mut context = Context::open(model, (&[], &[]), options, &[]);
    context.thorough = false;
    let lin = Linear::of(&system, &at, &keep, context.silent);
    let scoring = Scoring::new(&context, &system, &at, &lin, options.alpha * CATALOGUE_SHARE);
    let pass = score_catalogue(&system, &at, &scoring);
    let factors = if lin.rows.len() > MOST_SIMULATED {
        BTreeMap::new()
    } else {
        let simulation = Simulation::new(&context, (&system, &at), &lin, scoring.alpha);
        factors(&simulation, &pass, &wanted)
    };
    let sights = catalogue(&system, &at, &lin);
    let local: Vec<_> = local_effects(&system, &at, &lin).collect();
    let hidden_of_many = (sights.iter())
        .filter(|(_, sight)| matches!(sight, Estimability::NotEstimable(_)))
        .map(|(e, _)| *e);
    let hidden_of_one = (local.iter())
        .filter(|(_, sight)| matches!(sight, LocalEstimability::NotEstimable(_)))
        .map(|(e, _)| *e);
    let effects = &model.declared().effects;
    let hidden: Vec<usize> = (hidden_of_many.chain(hidden_of_one))
        .filter(|&e| wanted(&label(&effects[e].id, effects[e].subject.as_deref())))
        .collect();
    let assessor = Assessor {
        factors,
        system: &system,
        lin: &lin,
        alpha: pass.alpha_single,
        candidates: &pass.candidates,
        advice: Advice::on_hidden(model, &[], &hidden),
        imitation: Imitation::new(&system, &at, &lin),
    };
    let mut assessments = assessor.of_many(&sights, &pass.judged);
    assessments.extend(assessor.of_one(local));
    assessments.retain(|a| wanted(&label(&a.effect, a.subject.as_deref())));
    assessments.sort_by(|a, b| {
        label(&a.effect, a.subject.as_deref()).cmp(&label(&b.effect, b.subject.as_deref()))
    });
    Ok(assessments)
}

/// For every effect wanted its factor; where there are many of an id, that of the first of them.
fn factors(
    simulation: &Simulation<'_>,
    pass: &ScorePass,
    wanted: &impl Fn(&str) -> bool,
) -> BTreeMap<String, f64> {
    let (system, at, lin) = (simulation.system, simulation.at, simulation.lin);
    let local = local_effects(system, at, lin);
    let local = local.filter_map(|(e, _)| full_candidate(system, at, lin, e).candidate());
    let is_wanted = |c: &Candidate| wanted(&c.label());
    let mut firsts: BTreeMap<String, (usize, Cow<'_, Candidates>)> = BTreeMap::new();
    let of_many = pass.candidates.all.iter().enumerate();
    for (i, candidate) in of_many.filter(|(_, c)| is_wanted(c)) {
        firsts
            .entry(key(candidate, &pass.candidates))
            .or_insert((i, Cow::Borrowed(&pass.candidates)));
    }
    for candidate in local.filter(is_wanted) {
        if !firsts.contains_key(&candidate.id) {
            let (key, i) = (candidate.id.clone(), pass.candidates.all.len());
            firsts.insert(key, (i, Cow::Owned(pass.candidates.with(candidate))));
        }
    }
    let of = |(key, (i, among)): (String, (usize, Cow<'_, Candidates>))| {
        (key, simulation.factor(&among, i, pass.alpha_single))
    };
    firsts.into_par_iter().map(of).collect()
}

/// Of an id with this many subjects each is like the others: stations, channels of a kind.
const MANY: usize = 5;

/// The label; the id where there are many of it, or each lives in one group.
fn key(candidate: &Candidate, among: &Candidates) -> String {
    let of_id = among.all.iter().filter(|other| other.id == candidate.id).count();
    let is_one_of_many = of_id >= MANY || candidate.reach == Reach::One;
    if is_one_of_many { candidate.id.clone() } else { candidate.label() }
}

/// The fitted declared model, and the significance asked of one p-value.
struct Assessor<'a> {
    system: &'a System<'a>,
    lin: &'a Linear<'a>,
    /// By [`key`], how many times the size that the F test alone finds the whole choice asks for.
    factors: BTreeMap<String, f64>,
    alpha: f64,
    candidates: &'a Candidates,
    advice: Advice,
    imitation: Imitation<'a>,
}

impl Assessor<'_> {
    /// Effects that move many observations.
    fn of_many(&self, sights: &[(usize, Estimability)], judged: &[Scored]) -> Vec<Assessment> {
        let seen: Vec<_> = (sights.iter())
            .filter_map(|(_, s)| match s {
                Estimability::Estimable(c) => Some((**c).clone()),
                Estimability::NotEstimable(_) => None,
            })
            .collect();
        let class = classes(&seen);
        let assess = |(e, sight): &(usize, Estimability)| match sight {
            Estimability::NotEstimable(absorbed) => Some(self.hidden(*e, *absorbed)),
            Estimability::Estimable(candidate) => {
                let own = candidate.label();
                let test = judged.iter().find(|j| j.candidate.label() == own)?.test;
                let Source::Effect(active) = &candidate.source else { return None };
                let factor = self.factor(&key(candidate, self.candidates));
                let amplitudes =
                    factor * detectable_amplitudes(self.lin, &test, candidate, self.alpha);
                let position = seen.iter().position(|c| c.label() == own)?;
                let twin = |&i: &usize| position != i && class[position] == class[i];
                let visible = Visibility::Visible {
                    detectable: self.reported(*e, &active.parameters, amplitudes.as_slice()),
                    detectable_rms: factor * detectable_rms(self.lin, &test, candidate, self.alpha),
                    same_as: (0..seen.len()).filter(twin).map(|i| seen[i].label()).collect(),
                };
                Some(self.assessment(*e, candidate.absorbed(&self.lin.basis), visible))
            }
        };
        sights.iter().filter_map(assess).collect()
    }

    fn factor(&self, id: &str) -> f64 {
        self.factors.get(id).copied().unwrap_or(1.0)
    }

    /// Effects that move one observation each.
    fn of_one(&self, local: Vec<(usize, LocalEstimability)>) -> Vec<Assessment> {
        let mut known: Option<((usize, usize), f64)> = None;
        let mut lambda = |directions: usize, dof: usize| match known {
            Some((key, lambda)) if key == (directions, dof) => lambda,
            _ => {
                let lambda = noncentrality(self.alpha, directions, dof);
                known = Some(((directions, dof), lambda));
                lambda
            }
        };
        let observations = reported_observations(self.lin);
        let mut assess = |(e, sight): (usize, LocalEstimability)| match sight {
            LocalEstimability::NotEstimable(absorbed) => self.hidden(e, absorbed),
            LocalEstimability::Estimable(local) => {
                let lambda = lambda(local.test.directions, local.test.dof);
                let factor = self.factor(&self.system.model.declared().effects[e].id);
                let amplitudes: Vec<f64> = local_detectable_amplitudes(&local, lambda)
                    .into_iter()
                    .map(|size| factor * size)
                    .collect();
                let visible = Visibility::Visible {
                    detectable: self.reported(e, &local.parameters, &amplitudes),
                    detectable_rms: factor * local_detectable_rms(&local, lambda, observations),
                    same_as: Vec::new(),
                };
                self.assessment(e, local.absorbed, visible)
            }
        };
        local.into_iter().map(&mut assess).collect()
    }

    fn reported(
        &self,
        e: usize,
        parameters: &[usize],
        sizes: &[f64],
    ) -> Vec<(String, f64, String)> {
        let all = &self.system.model.declared().effects[e].parameters;
        let one = |(&p, size): (&usize, &f64)| {
            (all[p].name.clone(), size * all[p].report_factor.abs(), all[p].unit.clone())
        };
        parameters.iter().zip(sizes).map(one).collect()
    }

    fn hidden(&self, e: usize, absorbed: f64) -> Assessment {
        let sight = Visibility::Hidden {
            aliased_with: self.imitation.aliased_with(e),
            separate_by: self.advice.make_visible(e),
        };
        self.assessment(e, absorbed, sight)
    }

    fn assessment(&self, e: usize, absorbed: f64, sight: Visibility) -> Assessment {
        let effect = &self.system.model.declared().effects[e];
        Assessment {
            effect: effect.id.clone(),
            subject: effect.subject.clone(),
            description: effect.description.clone(),
            absorbed,
            sight,
        }
    }
}
