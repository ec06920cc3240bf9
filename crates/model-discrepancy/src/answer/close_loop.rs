//! The loop: fit, find what is missing, add it, judge it on data the fit never saw.

use crate::algebra::system::{Estimate, System, rows_of};
use crate::answer::confounded::{Attribution, attribute};
use crate::answer::confusable::confusability;
use crate::answer::contradiction::{contradiction, without_names};
use crate::answer::estimate::{Uncertain, parameter_estimates};
use crate::answer::external_validation::badly_predicted;
use crate::answer::left_over::{beside_larger_noise, remaining, structured};
use crate::answer::opened::{OpenLoop, open_loop};
use crate::answer::separation::{Advice, Imitation};
use crate::answer::summary::{Summaries, step_errors, summarise};
use crate::answer::unsupported::{TakenBack, Why, no_gain, outweighed, unsupported};
use crate::answer::verdict::{memory_within_the_noise, noisier_than_declared, verdict};
use crate::choice::candidate::{Candidate, Source, label};
use crate::choice::context::Context;
use crate::choice::selected::{Added, Selected, What};
use crate::error::LoopError;
use crate::noise::linear::Linear;
use crate::tests::lack_of_fit::{LackOfFit, Places};
use crate::tests::tails::{FarOff, heavy_tails, stands_out};
use crate::{
    Closure, Covariate, HoldOut, Model, NotObservable, Options, Outcome, Pass, Remaining, Role,
    Solution, Step,
};

/// Fits the declared model, finds what it lacks, and reports the error before and after.
///
/// `covariates` hold one value per observation. Every choice is made on groups with the role
/// `Fit`; groups with the role `Check` are only judged, but that names are taken back that they refute:
/// a single bad reading where they lie as far off, and others where they lie much farther off than without.
///
/// # Errors
///
/// [`LoopError`] when the layout is inconsistent, there are too few groups, or the declared
/// model itself is not determined by the data.
pub fn close_loop(
    model: &dyn Model,
    covariates: &[Covariate],
    options: &Options,
) -> Result<Closure, LoopError> {
    Ok(open_loop(model, covariates, options)?.close())
}

impl OpenLoop<'_> {
    /// Repeats the choice, takes back what does not stand, and says what is left.
    #[must_use]
    pub fn close(mut self) -> Closure {
        let (chosen, contradicted) = (self.chosen.clone(), self.contradicted.take());
        closed(&self.context(), (&self.keep, &self.base), chosen, contradicted)
    }
}

fn closed<'a>(
    context: &Context<'a>,
    (keep, base): (&[bool], &Estimate),
    mut chosen: Selected<'a>,
    contradicted: Option<Remaining>,
) -> Closure {
    let (model, silent) = (context.model, context.silent);
    let declared = System::declared(model);
    let of_declared = Linear::of(&declared, base, keep, silent);
    let rows = rows_of(&model.declared().layout, keep);
    let mut taken_back: Vec<Remaining> = contradicted.into_iter().collect();
    let mut by_chance = Vec::new();
    let places = Places::of(model, context.covariates);
    let (lin, attributions, summaries, left, lack_of_fit) = loop {
        let lin = Linear::of(&chosen.system, &chosen.estimate, keep, silent);
        let attributions: Vec<_> =
            chosen.added.iter().map(|a| attribute(context, keep, &chosen, &a.what)).collect();
        let summaries =
            summarise(context, keep, (base, &of_declared), (&chosen, &lin), &attributions);
        let back = unsupported((context, keep), (&chosen, &lin), &summaries, &taken_back);
        let left = match back {
            Some(_) => Vec::new(),
            None => structured(context, &chosen, &lin),
        };
        let is_quiet = left.is_empty() && !chosen.added.is_empty();
        let left = if is_quiet && noisier_than_declared(context, &lin, &chosen) {
            beside_larger_noise(context, &chosen, &lin)
        } else {
            left
        };
        let lack_of_fit = places.as_ref().and_then(|places| places.test(&lin));
        let repeats = lack_of_fit.as_ref().and_then(LackOfFit::remaining);
        let outweighed =
            || outweighed((context, keep), base, (&chosen, &lin), (&left, repeats.as_ref()));
        let Some(TakenBack { rest, why }) = back.or_else(outweighed) else {
            break (lin, attributions, summaries, left, lack_of_fit);
        };
        match why {
            Why::Left(remaining) => taken_back.push(remaining),
            Why::Chance(said) => by_chance.push(said),
        }
        chosen = rest;
        if let Some(contradicted) = contradiction(context, keep, base, &chosen) {
            chosen = without_names(context, keep, &chosen).unwrap_or(chosen);
            taken_back.push(contradicted);
        }
    };
    let hidden: Vec<usize> = chosen.not_estimable.iter().map(|&(effect, _)| effect).collect();
    let asked = (&attributions[..], &chosen.estimate.state.amplitudes[..]);
    let advice = Advice::new(model, silent, asked, &hidden);
    let steps = steps(context, keep, &chosen, &attributions, (&summaries, &advice));
    let badly_predicted = badly_predicted(context, &chosen, &lin);
    let mut remaining = remaining(context, left, badly_predicted.as_ref());
    remaining.extend(lack_of_fit.as_ref().and_then(LackOfFit::remaining));
    remaining.extend(taken_back);
    remaining.extend(no_gain(context, (&chosen, &lin), &summaries));
    let memory = memory_within_the_noise(&chosen, &lin, &mut remaining);
    let is_noisier = remaining.is_empty() && noisier_than_declared(context, &lin, &chosen);
    if is_noisier {
        remaining = beside_larger_noise(context, &chosen, &lin);
    }
    let (confusability, confusable_ids) = confusability(context, base, &of_declared);
    mark_confounded(&mut chosen.passes, &attributions);
    let mut warnings = warnings(context, &chosen, silent);
    warnings
        .extend(looked_for(context, &chosen).filter(|_| {
            matches!(summaries.after.hold_out, HoldOut::Nested | HoldOut::LeaveOneOut)
        }));
    warnings.extend(memory);
    warnings.extend(by_chance);
    warnings.extend(summaries.warnings);
    warnings.extend(heavy_tails(&lin).map(|freedom| {
        format!(
            "the noise has heavier tails than a normal distribution, as Student's t with about \
             {freedom:.0} degrees of freedom: a reading far off need not be a mistake, and a robust \
             loss would give it less weight"
        )
    }));
    let is_open = is_noisier || !remaining.is_empty();
    warnings
        .extend(is_open.then(|| stands_out(&lin)).flatten().map(|far| maybe_a_mistake(&lin, far)));
    let uncertain = Uncertain::of(&chosen.system, &chosen.estimate, keep);
    Closure {
        verdict: verdict(context, &chosen, &remaining, is_noisier),
        not_observable: not_observable(&declared, (base, &of_declared), &chosen, &advice),
        residuals_before: declared.residuals(base).iter().copied().collect(),
        residuals_after: chosen.system.residuals(&chosen.estimate).iter().copied().collect(),
        covariance: uncertain.covariance,
        columns: uncertain.columns,
        jacobian: uncertain.jacobian,
        alternatives: alternatives(&rows, &chosen, &attributions),
        variance_factor: uncertain.noise.variance_factor,
        degrees_of_freedom: uncertain.noise.degrees_of_freedom,
        empirical: chosen.system.corrections(&chosen.estimate),
        state: chosen.estimate.state,
        before: summaries.before,
        after: summaries.after,
        passes: chosen.passes,
        steps,
        remaining,
        lack_of_fit,
        odd_check: badly_predicted.and_then(|of| of.alone),
        confusability,
        confusable_ids,
        warnings,
    }
}

/// Most other names that are fitted: with more, the name says nothing anyway.
const MOST_ALTERNATIVES: usize = 16;

/// The final model with each step replaced by every catalogue effect that could be in its place.
fn alternatives(
    rows: &[usize],
    chosen: &Selected<'_>,
    attributions: &[Option<Attribution<'_>>],
) -> Vec<Solution> {
    let pairs =
        attributions.iter().flatten().flat_map(|a| a.confounded.iter().map(move |r| (a, r)));
    let of = |(attribution, rival): (&Attribution<'_>, &Candidate)| {
        if !matches!(rival.source, Source::Effect(_)) {
            return None;
        }
        let system = rival.added_to(&attribution.system);
        let fitted = system.fit_anew(rows, &system.warm_start(&chosen.estimate)).ok()?;
        Some(Solution { columns: system.columns(), state: fitted.state })
    };
    pairs.take(MOST_ALTERNATIVES).filter_map(of).collect()
}

fn steps(
    context: &Context<'_>,
    keep: &[bool],
    chosen: &Selected<'_>,
    attributions: &[Option<Attribution<'_>>],
    (summaries, advice): (&Summaries, &Advice),
) -> Vec<Step> {
    let errors = step_errors(context, keep, chosen);
    let step = |(i, added): (usize, &Added)| {
        let attribution = attributions[i].as_ref();
        let (effect, subject, description) = describe(context, &added.what);
        Step {
            effect,
            subject,
            description,
            parameters: parameter_estimates(context, chosen, keep, &added.what),
            p_value: added.p_value,
            held_out_rms: errors[i].held_out_rms,
            train_rms: errors[i].train_rms,
            indistinguishable_from: attribution.map(Attribution::names).unwrap_or_default(),
            rivals: attribution.map(Attribution::labels).unwrap_or_default(),
            separate_by: advice.separate_by[i].clone(),
            stability: summaries.stability.get(i).copied().unwrap_or_default(),
        }
    };
    chosen.added.iter().enumerate().map(step).collect()
}

fn describe(context: &Context<'_>, what: &What) -> (String, Option<String>, String) {
    match what {
        What::Effect(e) => {
            let effect = &context.model.declared().effects[*e];
            (effect.id.clone(), effect.subject.clone(), effect.description.clone())
        }
        What::Empirical(covariate, shape) => (
            format!("covariate:{covariate}"),
            None,
            format!(
                "empirical correction along {covariate}, shape {shape}; its cause is not named"
            ),
        ),
    }
}

fn not_observable(
    declared: &System<'_>,
    (base, lin): (&Estimate, &Linear<'_>),
    chosen: &Selected<'_>,
    advice: &Advice,
) -> Vec<NotObservable> {
    let imitation = Imitation::new(declared, base, lin);
    let mut found: Vec<NotObservable> = Vec::new();
    for &(e, _) in &chosen.not_estimable {
        let effect = &declared.model.declared().effects[e];
        let name = label(&effect.id, effect.subject.as_deref());
        if found.iter().any(|n| n.effect == name) {
            continue;
        }
        found.push(NotObservable {
            effect: name,
            aliased_with: imitation.aliased_with(e),
            separate_by: advice.make_visible(e),
        });
    }
    found
}

/// Marks, in the tables of all passes, the candidates that the data accept in place of a step.
fn mark_confounded(passes: &mut [Pass], attributions: &[Option<Attribution<'_>>]) {
    let confounded: Vec<_> = attributions
        .iter()
        .flatten()
        .flat_map(|a| a.confounded.iter().map(Candidate::label))
        .collect();
    for pass in passes {
        let added = pass.scores.iter().any(|s| s.outcome == Outcome::Added);
        for score in pass.scores.iter_mut().filter(|_| added) {
            let beaten = matches!(score.outcome, Outcome::Weaker | Outcome::NotSignificant);
            if beaten && confounded.contains(&score.label) {
                score.outcome = Outcome::Rival;
            }
        }
    }
}

fn warnings(context: &Context<'_>, chosen: &Selected<'_>, silent: &[bool]) -> Vec<String> {
    let mut warnings = Vec::new();
    for component in (0..silent.len()).filter(|&c| silent[c]) {
        let name = ["x", "y", "z"].get(component).copied().unwrap_or("a component");
        warnings.push(format!(
            "{name} agrees to round-off in every observation: taken as not measured, and left out of every test"
        ));
    }
    let groups =
        context.model.declared().layout.groups.iter().filter(|g| g.role == Role::Fit).count();
    if groups < 8 && !chosen.added.is_empty() {
        warnings.push(format!(
            "what was added rests on {groups} groups; measure more before relying on it"
        ));
    }
    warnings
}

/// That one reading lies so far off that it may be a mistake, though not so far that it must be one.
fn maybe_a_mistake(lin: &Linear<'_>, FarOff { observation, z, chance }: FarOff) -> String {
    let group = &lin.layout.groups[lin.layout.observations[observation]].name;
    format!(
        "a reading of {group} lies {z:.1} standard uncertainties off, where noise with the tails that the others allow puts \
         one with a chance of {chance:.1e}: measure it again, or leave it out and see what changes"
    )
}

/// What every reading has had a part in finding, whichever is left out.
fn looked_for(context: &Context<'_>, chosen: &Selected<'_>) -> Option<String> {
    let effects = &context.model.declared().effects;
    let of = |added: &Added| match added.what {
        What::Effect(e) if effects[e].searched > 1 => {
            Some(label(&effects[e].id, effects[e].subject.as_deref()))
        }
        _ => None,
    };
    let names: Vec<String> = chosen.added.iter().filter_map(of).collect();
    (!names.is_empty()).then(|| {
        format!(
            "the place, period, order or time constant of {} was looked for in all readings that were \
             fitted: so far the held-out error has seen what it is judged on",
            names.join(", ")
        )
    })
}
