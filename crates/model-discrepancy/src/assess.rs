//! What a design can see, before or without any finding.

use crate::candidate::{Sight, catalogue, classes, label};
use crate::detectable::{detectable_amplitudes, detectable_rms};
use crate::error::LoopError;
use crate::judge::{Bench, Setting, hear_catalogue};
use crate::linear::Linear;
use crate::select::CATALOGUE_SHARE;
use crate::separation::{aliased_with, all_fitted, make_visible};
use crate::system::{System, rows_of};
use crate::validate::validate;
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
    let rows = rows_of(model.layout(), &keep);
    let at = system.fit_anew(&rows, &system.start()).map_err(LoopError::declared)?;
    let setting = Setting { model, covariates: &[], options, silent: &[], thorough: false };
    let lin = Linear::of(&system, &at, &keep, setting.silent);
    let bench = Bench::new(&setting, &system, &at, &lin, options.alpha * CATALOGUE_SHARE);
    let hearing = hear_catalogue(&system, &at, &bench);

    let sights = catalogue(&system, &at, &lin);
    let seen: Vec<_> = (sights.iter())
        .filter_map(|(_, s)| match s {
            Sight::Seen(c) => Some((**c).clone()),
            Sight::Unseen(_) => None,
        })
        .collect();
    let class = classes(&seen, &lin.basis);
    let mut assessments = Vec::new();
    for (e, sight) in &sights {
        let effect = &model.effects()[*e];
        let (absorbed, sight) = match sight {
            Sight::Unseen(absorbed) => {
                let aliased_with = aliased_with(&system, &at, &lin, *e);
                (
                    *absorbed,
                    Visibility::Hidden { aliased_with, separate_by: make_visible(model, *e, &[]) },
                )
            }
            Sight::Seen(candidate) => {
                let own = candidate.label();
                let Some(judged) = hearing.judged.iter().find(|j| j.candidate.label() == own)
                else {
                    continue;
                };
                let amplitudes =
                    detectable_amplitudes(&lin, &judged.test, candidate, hearing.alpha_single);
                let crate::candidate::Source::Effect(active) = &candidate.source else { continue };
                let detectable = (active.parameters.iter().zip(amplitudes.iter()))
                    .map(|(&p, a)| {
                        let p = &effect.parameters[p];
                        (p.name.clone(), a * p.report_factor.abs(), p.unit.clone())
                    })
                    .collect();
                let position = seen.iter().position(|c| c.label() == own);
                let same_as = (0..seen.len())
                    .filter(|&i| position.is_some_and(|p| p != i && class[p] == class[i]))
                    .map(|i| seen[i].label())
                    .collect();
                let rms = detectable_rms(&lin, &judged.test, candidate, hearing.alpha_single);
                (
                    candidate.absorbed,
                    Visibility::Visible { detectable, detectable_rms: rms, same_as },
                )
            }
        };
        assessments.push(Assessment {
            effect: effect.id.clone(),
            subject: effect.subject.clone(),
            description: effect.description.clone(),
            absorbed,
            sight,
        });
    }
    assessments.sort_by(|a, b| {
        label(&a.effect, a.subject.as_deref()).cmp(&label(&b.effect, b.subject.as_deref()))
    });
    Ok(assessments)
}
