//! What a design can see, before or without any finding.

use crate::algebra::system::{Estimate, System, rows_of};
use crate::answer::separation::{Further, Imitation, all_fitted};
use crate::choice::candidate::{Estimability, Source, catalogue, classes, label};
use crate::choice::context::Context;
use crate::choice::detectable::{
    detectable_amplitudes, detectable_rms, local_detectable_amplitudes, local_detectable_rms,
    noncentrality,
};
use crate::choice::one_observation::{LocalEstimability, local_effects};
use crate::choice::score::{Scored, Scoring, score_catalogue};
use crate::error::LoopError;
use crate::levels::CATALOGUE_SHARE;
use crate::model::validate::validate;
use crate::noise::linear::Linear;
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
        /// Smallest amplitude of each parameter alone that is found 9 times in 10 at the noise of
        /// these data, in report units: name, value, unit.
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

/// Assesses every effect of the catalogue at the fitted declared model.
///
/// # Errors
///
/// As [`close_loop`](crate::close_loop).
pub fn assess(model: &dyn Model, options: &Options) -> Result<Vec<Assessment>, LoopError> {
    validate(model, &[])?;
    let keep = all_fitted(model);
    let system = System::declared(model);
    let rows = rows_of(&model.declared().layout, &keep);
    let at = system.fit_first(&rows).map_err(LoopError::declared)?;
    let context =
        Context { model, covariates: &[], options, silent: &[], banned: &[], thorough: false };
    let lin = Linear::of(&system, &at, &keep, context.silent);
    let scoring = Scoring::new(&context, &system, &at, &lin, options.alpha * CATALOGUE_SHARE);
    let pass = score_catalogue(&system, &at, &scoring);
    let assessor = Assessor {
        system: &system,
        at: &at,
        lin: &lin,
        alpha: pass.alpha_single,
        further: Further::new(model, &[]),
        imitation: Imitation::new(&system, &at, &lin),
    };
    let mut assessments = assessor.of_many(&pass.judged);
    assessments.extend(assessor.of_one());
    assessments.sort_by(|a, b| {
        label(&a.effect, a.subject.as_deref()).cmp(&label(&b.effect, b.subject.as_deref()))
    });
    Ok(assessments)
}

/// The fitted declared model, and the significance asked of one p-value.
struct Assessor<'a> {
    system: &'a System<'a>,
    at: &'a Estimate,
    lin: &'a Linear<'a>,
    alpha: f64,
    further: Further<'a>,
    imitation: Imitation<'a>,
}

impl Assessor<'_> {
    /// Effects that move many observations.
    fn of_many(&self, judged: &[Scored]) -> Vec<Assessment> {
        let sights = catalogue(self.system, self.at, self.lin);
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
                let amplitudes = detectable_amplitudes(self.lin, &test, candidate, self.alpha);
                let position = seen.iter().position(|c| c.label() == own)?;
                let twin = |&i: &usize| position != i && class[position] == class[i];
                let visible = Visibility::Visible {
                    detectable: self.reported(*e, &active.parameters, amplitudes.as_slice()),
                    detectable_rms: detectable_rms(self.lin, &test, candidate, self.alpha),
                    same_as: (0..seen.len()).filter(twin).map(|i| seen[i].label()).collect(),
                };
                Some(self.assessment(*e, candidate.absorbed(&self.lin.basis), visible))
            }
        };
        sights.iter().filter_map(assess).collect()
    }

    /// Effects that move one observation each.
    fn of_one(&self) -> Vec<Assessment> {
        let mut known: Option<((usize, usize), f64)> = None;
        let mut lambda = |directions: usize, dof: usize| match known {
            Some((key, lambda)) if key == (directions, dof) => lambda,
            _ => {
                let lambda = noncentrality(self.alpha, directions, dof);
                known = Some(((directions, dof), lambda));
                lambda
            }
        };
        let mut assess = |(e, sight): (usize, LocalEstimability)| match sight {
            LocalEstimability::NotEstimable(absorbed) => self.hidden(e, absorbed),
            LocalEstimability::Estimable(local) => {
                let lambda = lambda(local.test.directions, local.test.dof);
                let amplitudes = local_detectable_amplitudes(&local, lambda);
                let visible = Visibility::Visible {
                    detectable: self.reported(e, &local.parameters, &amplitudes),
                    detectable_rms: local_detectable_rms(self.lin, &local, lambda),
                    same_as: Vec::new(),
                };
                self.assessment(e, local.absorbed, visible)
            }
        };
        local_effects(self.system, self.at, self.lin).into_iter().map(&mut assess).collect()
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
            separate_by: self.further.make_visible(e),
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
