//! Errors before and after, on the data that made the models and on data they never saw.

use crate::algebra::system::{Estimate, System, rows_of};
use crate::answer::confounded::Attribution;
use crate::answer::found_again::where_readings_move;
use crate::answer::unseen::{Unseen, reported_errors, unseen_before, unseen_errors};
use crate::choice::context::Context;
use crate::choice::score::excluded;
use crate::choice::selected::{Selected, What};
use crate::levels::CHOICE_FOLDS;
use crate::noise::linear::Linear;
use crate::tests::global_test::global_test;
use crate::tests::hold_out::{GroupError, folds, leave_out, rms};
use crate::{ErrorSummary, HoldOut, Stability};

/// Errors of the declared and the final model.
pub(crate) struct Summaries {
    pub(crate) before: ErrorSummary,
    pub(crate) after: ErrorSummary,
    /// Squared errors on unseen groups, after over before, of all rows in units of their noise: what
    /// shows in rows that are not reported counts, too.
    pub(crate) unseen_ratio: f64,
    /// The same without the few groups for which repetitions chose something else.
    pub(crate) gain_ratio: f64,
    /// Their names.
    pub(crate) strays: Vec<String>,
    /// Of every addition.
    pub(crate) stability: Vec<Stability>,
    pub(crate) warnings: Vec<String>,
}

/// Errors of one model.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepErrors {
    pub(crate) train_rms: f64,
    pub(crate) held_out_rms: f64,
}

pub(crate) fn summarise(
    context: &Context<'_>,
    keep: &[bool],
    declared: (&Estimate, &Linear<'_>),
    (chosen, lin): (&Selected<'_>, &Linear<'_>),
    attributions: &[Option<Attribution<'_>>],
) -> Summaries {
    let base = declared.0;
    let named_bad = excluded(context, &chosen.system, &chosen.estimate, lin);
    let skip_groups = groups_of(lin, &named_bad);
    let mut warnings: Vec<_> = skip_groups
        .iter()
        .map(|&g| {
            format!(
                "{} is named a bad reading: errors on unseen groups leave it out",
                context.model.declared().layout.groups[g].name
            )
        })
        .collect();
    let Unseen { hold_out, mut errors, found_again, strays } =
        unseen_errors(context, keep, declared, (chosen, lin), attributions, &skip_groups);
    let perturbed = if context.options.nested {
        where_readings_move(context, keep, declared, (chosen, lin), attributions)
    } else {
        vec![None; chosen.added.len()]
    };
    let stability = found_again.into_iter().zip(perturbed);
    if chosen.added.is_empty() {
        // Repetitions may still add what was taken back.
        let [before, after] = &mut errors;
        after.clone_from(before);
    }
    if hold_out == HoldOut::LeaveOneOut && !chosen.added.is_empty() {
        warnings.push("the held-out error leaves out one group at a time, but the effects were chosen with all of them: too few groups to repeat the choice".to_owned());
    }
    let [before, after] = errors.each_ref().map(|errors| (hold_out, &errors[..]));
    let groups = &context.model.declared().layout.groups;
    let fitted: Vec<usize> = (0..groups.len()).filter(|&g| keep[g]).collect();
    let plain = System::declared(context.model);
    Summaries {
        before: error_summary((&plain, base), declared.1, keep, before),
        after: error_summary((&chosen.system, &chosen.estimate), lin, keep, after),
        unseen_ratio: ratio(&errors, &[]),
        gain_ratio: ratio(&errors, &strays),
        strays: strays.iter().map(|&i| groups[fitted[i]].name.clone()).collect(),
        stability: stability
            .map(|(resampled, perturbed)| Stability { resampled, perturbed })
            .collect(),
        warnings,
    }
}

/// The error of the declared model alone, `chosen` being what else was.
pub(crate) fn summary_before(
    context: &Context<'_>,
    keep: &[bool],
    base: &Estimate,
    chosen: &Selected<'_>,
) -> ErrorSummary {
    let declared = System::declared(context.model);
    let of_declared = Linear::of(&declared, base, keep, context.silent);
    let lin = Linear::of(&chosen.system, &chosen.estimate, keep, context.silent);
    let named_bad = excluded(context, &chosen.system, &chosen.estimate, &lin);
    let (hold_out, errors) =
        unseen_before(context, keep, (base, &of_declared), &lin, &groups_of(&lin, &named_bad));
    error_summary((&declared, base), &of_declared, keep, (hold_out, &errors))
}

/// Layout groups of the clusters for which `some` is true.
fn groups_of(lin: &Linear<'_>, some: &[bool]) -> Vec<usize> {
    (0..some.len()).filter(|&c| some[c]).map(|c| lin.cluster_groups[c]).collect()
}

fn error_summary(
    (system, at): (&System<'_>, &Estimate),
    lin: &Linear<'_>,
    keep: &[bool],
    (hold_out, errors): (HoldOut, &[Option<GroupError>]),
) -> ErrorSummary {
    let (held_out_rms, held_out_std) = rms(errors);
    let test = global_test(system, at, lin);
    ErrorSummary {
        train_rms: train_rms(system, at, keep),
        held_out_rms,
        held_out_std,
        hold_out,
        unit: lin.layout.unit.clone(),
        chi2_per_dof: test.map(|t| t.per_dof()),
        chi2_interval: test.map(|t| t.interval()),
    }
}

fn ratio([before, after]: &[Vec<Option<GroupError>>; 2], without: &[usize]) -> f64 {
    let judged = before.iter().zip(after).enumerate().filter(|(i, _)| !without.contains(i));
    let both = judged.filter_map(|(_, (b, a))| Some((b.as_ref()?, a.as_ref()?)));
    let (before, after) =
        both.fold((0.0, 0.0), |(b, a), (before, after)| (b + before.whitened, a + after.whitened));
    after / f64::max(before, f64::MIN_POSITIVE)
}

fn train_rms(system: &System<'_>, at: &Estimate, keep: &[bool]) -> f64 {
    let groups: Vec<_> = (0..keep.len()).filter(|&g| keep[g]).collect();
    rms(&reported_errors(system, at, &groups)).0
}

/// Errors of the model after each step.
pub(crate) fn step_errors(
    context: &Context<'_>,
    keep: &[bool],
    chosen: &Selected<'_>,
) -> Vec<StepErrors> {
    let mut system = System::declared(context.model);
    let rows = rows_of(&context.model.declared().layout, keep);
    let mut errors = Vec::new();
    for added in &chosen.added {
        system = match &added.what {
            What::Effect(e) => match chosen.system.active.iter().find(|a| a.effect == *e) {
                Some(active) => system.with_effect(active.clone()),
                None => system,
            },
            What::Empirical(covariate, shape) => chosen
                .system
                .empirical
                .iter()
                .find(|e| e.covariate == *covariate && e.shape == *shape)
                .map_or(system.clone(), |e| system.with_empirical(e.clone())),
        };
        let start = system.warm_start(&chosen.estimate);
        let at = system.fit_anew(&rows, &start).unwrap_or(start);
        let lin = Linear::of(&system, &at, keep, context.silent);
        let skip = excluded(context, &system, &at, &lin);
        let left_out = leave_out(&lin, &lin.basis, &folds(lin.clusters.len(), CHOICE_FOLDS), &skip);
        errors.push(StepErrors {
            train_rms: train_rms(&system, &at, keep),
            held_out_rms: rms(&left_out).0,
        });
    }
    errors
}
