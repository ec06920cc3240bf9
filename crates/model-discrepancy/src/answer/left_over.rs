//! What is left of the residual, with what there is to say of it.

use crate::answer::changing_size::of_changing_size;
use crate::answer::common_errors::common_errors;
use crate::answer::constancy::inconstant;
use crate::answer::external_validation::BadlyPredicted;
use crate::answer::structure::{structure, traces_of_structure};
use crate::choice::additivity::not_additive;
use crate::choice::candidate::Source;
use crate::choice::context::Context;
use crate::choice::score::Scoring;
use crate::choice::score_shapes::score_covariates;
use crate::choice::selected::{Selected, What};
use crate::levels::{HARDLY_NOISE, QUARTER};
use crate::noise::linear::Linear;
use crate::tests::global_test::global_test;
use crate::tests::groups_apart::groups_apart;
use crate::tests::odd_group::{odd_groups, odd_scatter};
use crate::tests::odd_stretch::odd_stretch;
use crate::{Origin, Remaining};

/// What is left in the fitted groups (see [`structured`]), with what groups set aside and the domain itself say.
pub(crate) fn remaining(
    context: &Context<'_>,
    structured: Vec<Remaining>,
    badly_predicted: Option<&BadlyPredicted>,
) -> Vec<Remaining> {
    let mut found = structured;
    found.extend(badly_predicted.map(|of| of.remaining.clone()));
    found.extend(context.model.declared().findings.clone());
    found
}

/// What is still there along a covariate, of a name or between neighbours, in the fitted groups.
pub(crate) fn structured(
    context: &Context<'_>,
    chosen: &Selected<'_>,
    lin: &Linear<'_>,
) -> Vec<Remaining> {
    let mut found = along_covariates(context, (chosen, lin), context.options.alpha * QUARTER);
    // A correction along a position or the measured order has no named cause.
    for added in &chosen.added {
        if let What::Empirical(covariate, shape) = &added.what {
            let coordinate = context
                .covariates
                .iter()
                .any(|c| c.name == *covariate && c.origin == Origin::Coordinate);
            if coordinate && found.iter().all(|r| r.covariate != *covariate) {
                let (covariate, shape) = (covariate.clone(), format!("{shape} (corrected)"));
                found.push(Remaining { covariate, shape, p_value: added.p_value });
            }
        }
    }
    found.extend(not_additive(context, chosen, lin).into_iter().map(|d| d.remaining));
    found.extend(structure(context, lin));
    found.extend(odd_groups(lin).or_else(|| groups_apart(lin)));
    found.extend(odd_stretch(lin));
    found.extend(inconstant(context, lin));
    found
}

/// What is left where only noise, larger than declared, seems to be: a group that scatters more than the others, and
/// the slightest trace of a shape, of neighbours that agree, of an error in common, or of an effect of changing size.
pub(crate) fn beside_larger_noise(
    context: &Context<'_>,
    chosen: &Selected<'_>,
    lin: &Linear<'_>,
) -> Vec<Remaining> {
    let mut found = along_covariates(context, (chosen, lin), context.options.alpha);
    found.extend(traces_of_structure(context, lin));
    found.extend(odd_scatter(lin));
    found.extend(common_errors(context, lin));
    if found.is_empty() {
        found.extend(of_changing_size(context, chosen, lin));
    }
    if found.is_empty() {
        found.extend(hardly_noise(chosen, lin));
    }
    found
}

/// What [`Remaining::covariate`] is of scatter that goes with nothing and is too large to be noise.
pub const SCATTER: &str = "scatter";

/// What scatters so many times as much as declared that nobody declares its noise so wrongly, whatever it is.
fn hardly_noise(chosen: &Selected<'_>, lin: &Linear<'_>) -> Option<Remaining> {
    let test = global_test(&chosen.system, &chosen.estimate, lin)?;
    let shape = format!(
        "{:.0} times the declared noise: hardly noise, and it goes with nothing that is known",
        test.per_dof().sqrt()
    );
    let covariate = SCATTER.to_owned();
    let p_value = test.p_value();
    (test.per_dof() >= HARDLY_NOISE).then_some(Remaining { covariate, shape, p_value })
}

/// The best shape along every covariate whose significance, all that were tried counted, is below `level`.
fn along_covariates(
    context: &Context<'_>,
    (chosen, lin): (&Selected<'_>, &Linear<'_>),
    level: f64,
) -> Vec<Remaining> {
    let quick = Context { thorough: false, ..*context };
    let scoring = Scoring::new(&quick, &chosen.system, &chosen.estimate, lin, level);
    let mut found: Vec<Remaining> = Vec::new();
    let mut judged = score_covariates(context, &scoring);
    judged.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
    for mut j in judged {
        let covariate = j.candidate.id.trim_start_matches("covariate:").to_owned();
        if found.iter().any(|r| r.covariate == covariate) {
            // One line a column: its best shape.
            continue;
        }
        j.confirm(&scoring);
        if j.adjusted <= level {
            let shape = match j.candidate.source {
                Source::Empirical(e) => e.shape,
                Source::Effect(_) => continue,
            };
            found.push(Remaining { covariate, shape, p_value: j.test.p_value });
        }
    }
    found
}
