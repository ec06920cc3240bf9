//! Errors before and after, on the data that made the models and on data they never saw.

use crate::levels::MIN_NESTED_GROUPS;
use rayon::prelude::*;

use crate::algebra::system::{Estimate, System, rows_of};
use crate::answer::confounded::Attribution;
use crate::answer::found_again::{found_again, shares, where_readings_move};
use crate::choice::blocks::{Blocks, WithoutBlock};
use crate::choice::context::Context;
use crate::choice::score::excluded;
use crate::choice::select::select;
use crate::choice::selected::{Selected, What};
use crate::levels::CHOICE_FOLDS;
use crate::noise::linear::Linear;
use crate::tests::global_test::global_test;
use crate::tests::hold_out::{GroupError, folds, leave_out, rms};
use crate::{ErrorSummary, HoldOut, Role, Stability};

/// Repetitions of the choice at most; each leaves out every so-manieth group.
const MAX_NESTED_FOLDS: usize = 24;

/// Errors of the declared and the final model.
pub(crate) struct Summaries {
    pub(crate) before: ErrorSummary,
    pub(crate) after: ErrorSummary,
    /// Whether unseen groups are predicted better after than before, by the squared errors of all
    /// rows in units of their noise: what shows in rows that are not reported counts, too.
    pub(crate) predicts_better: bool,
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
    base: &Estimate,
    chosen: &Selected<'_>,
    attributions: &[Option<Attribution<'_>>],
) -> Summaries {
    let declared = System::declared(context.model);
    let lin = Linear::of(&chosen.system, &chosen.estimate, keep, context.silent);
    let named_bad = excluded(context, &chosen.system, &chosen.estimate, &lin);
    let skip_groups: Vec<_> =
        (0..named_bad.len()).filter(|&c| named_bad[c]).map(|c| lin.cluster_groups[c]).collect();
    let mut warnings: Vec<_> = skip_groups
        .iter()
        .map(|&g| {
            format!(
                "{} is named a bad reading: errors on unseen groups leave it out",
                context.model.declared().layout.groups[g].name
            )
        })
        .collect();
    let (hold_out, mut errors, resampled) =
        unseen_errors(context, keep, base, chosen, attributions, &skip_groups);
    let perturbed = if context.options.nested {
        where_readings_move(context, keep, base, chosen, attributions)
    } else {
        vec![None; chosen.added.len()]
    };
    let stability = resampled.into_iter().zip(perturbed);
    if chosen.added.is_empty() {
        // Repetitions may still add what was taken back.
        let [before, after] = &mut errors;
        after.clone_from(before);
    }
    if hold_out == HoldOut::LeaveOneOut && !chosen.added.is_empty() {
        warnings.push("the held-out error leaves out one group at a time, but the effects were chosen with all of them: too few groups to repeat the choice".to_owned());
    }
    let summary = |system: &System<'_>, at: &Estimate, errors: &[Option<GroupError>]| {
        let (held_out_rms, held_out_std) = rms(errors);
        let lin = Linear::of(system, at, keep, context.silent);
        let test = global_test(system, at, &lin);
        ErrorSummary {
            train_rms: train_rms(system, at, keep),
            held_out_rms,
            held_out_std,
            hold_out,
            unit: context.model.declared().layout.unit.clone(),
            chi2_per_dof: test.map(|t| t.per_dof()),
            chi2_interval: test.map(|t| t.interval()),
        }
    };
    Summaries {
        before: summary(&declared, base, &errors[0]),
        after: summary(&chosen.system, &chosen.estimate, &errors[1]),
        predicts_better: predicts_better(&errors),
        stability: stability
            .map(|(resampled, perturbed)| Stability { resampled, perturbed })
            .collect(),
        warnings,
    }
}

fn predicts_better([before, after]: &[Vec<Option<GroupError>>; 2]) -> bool {
    let both = before.iter().zip(after).filter_map(|(b, a)| Some((b.as_ref()?, a.as_ref()?)));
    both.map(|(before, after)| after.whitened - before.whitened).sum::<f64>() < 0.0
}

type Unseen = (HoldOut, [Vec<Option<GroupError>>; 2], Vec<Option<f64>>);

fn unseen_errors(
    context: &Context<'_>,
    keep: &[bool],
    base: &Estimate,
    chosen: &Selected<'_>,
    attributions: &[Option<Attribution<'_>>],
    skip_groups: &[usize],
) -> Unseen {
    let groups = &context.model.declared().layout.groups;
    let declared = System::declared(context.model);
    let checks: Vec<_> = (0..groups.len()).filter(|&g| groups[g].role == Role::Check).collect();
    let fitted: Vec<_> = (0..groups.len()).filter(|&g| keep[g]).collect();
    let nested = context.options.nested && fitted.len() >= MIN_NESTED_GROUPS;
    let repeated = (nested && (checks.is_empty() || !chosen.added.is_empty()))
        .then(|| nested_errors(context, keep, base, chosen, attributions, &fitted, skip_groups));
    if !checks.is_empty() {
        let before = reported_errors(&declared, base, &checks);
        let after = reported_errors(&chosen.system, &chosen.estimate, &checks);
        let stability = repeated.map_or(vec![None; chosen.added.len()], |(_, stability)| stability);
        return (HoldOut::CheckGroups, [before, after], stability);
    }
    if let Some((errors, stability)) = repeated {
        return (HoldOut::Nested, errors, stability);
    }
    let single = |system: &System<'_>, at: &Estimate| {
        let lin = Linear::of(system, at, keep, context.silent);
        let skip: Vec<_> = lin.cluster_groups.iter().map(|g| skip_groups.contains(g)).collect();
        leave_out(&lin, &lin.basis, &folds(lin.clusters.len(), CHOICE_FOLDS), &skip)
    };
    let errors = [single(&declared, base), single(&chosen.system, &chosen.estimate)];
    (HoldOut::LeaveOneOut, errors, vec![None; chosen.added.len()])
}

/// Repeats the whole choice without each fold and predicts the fold.
fn nested_errors(
    context: &Context<'_>,
    keep: &[bool],
    base: &Estimate,
    chosen: &Selected<'_>,
    attributions: &[Option<Attribution<'_>>],
    fitted: &[usize],
    skip_groups: &[usize],
) -> ([Vec<Option<GroupError>>; 2], Vec<Option<f64>>) {
    let fold = folds(fitted.len(), MAX_NESTED_FOLDS);
    let n_folds = fold.iter().max().map_or(0, |f| f + 1);
    let members = |f: usize| -> Vec<usize> {
        (0..fitted.len()).filter(|&i| fold[i] == f && !skip_groups.contains(&fitted[i])).collect()
    };
    let progress = &context.options.progress;
    progress.expect(n_folds);
    let left_out: Vec<Vec<usize>> =
        (0..n_folds).map(|f| members(f).into_iter().map(|i| fitted[i]).collect()).collect();
    let blocks = seen_in_blocks(context, keep, base, chosen, &left_out);
    // Each repetition stands alone, so the answer does not depend on the number of threads.
    let repetitions: Vec<_> = (0..n_folds)
        .into_par_iter()
        .filter_map(|block| {
            let known = WithoutBlock { blocks: &blocks, block };
            let quick = Context { thorough: false, without_block: Some(known), ..*context };
            let repetition = repeat_without(&quick, keep, base, chosen, &left_out[block]);
            progress.done();
            Some((members(block), repetition?))
        })
        .collect();
    let mut errors = [vec![None; fitted.len()], vec![None; fitted.len()]];
    let open = undetermined(context, keep, chosen, (fitted, &fold), skip_groups);
    for (members, repetition) in &repetitions {
        for (k, &i) in members.iter().enumerate().filter(|(_, i)| !open.contains(i)) {
            errors[0][i] = repetition.before[k];
            errors[1][i] = repetition.after[k];
        }
    }
    let choices: Vec<_> = repetitions.into_iter().map(|(_, r)| r.added).collect();
    (errors, shares(chosen, attributions, &choices))
}

/// The declared model, and the chosen one, by sums over the blocks that are left out.
fn seen_in_blocks<'a>(
    context: &Context<'a>,
    keep: &[bool],
    base: &Estimate,
    chosen: &Selected<'a>,
    left_out: &[Vec<usize>],
) -> Vec<Blocks<'a>> {
    let declared = System::declared(context.model);
    let of = |system: &System<'a>, at: &Estimate| {
        let lin = Linear::of(system, at, keep, context.silent);
        Blocks::of(
            (context.covariates, context.shapes),
            context.banned,
            (system, at),
            &lin,
            left_out,
        )
    };
    let systems = [(&declared, base), (&chosen.system, &chosen.estimate)];
    let different = if chosen.system.is_same(&declared) { 1 } else { 2 };
    systems[..different].iter().filter_map(|(system, at)| of(system, at)).collect()
}

/// Groups of which the chosen model predicts nothing from the others: what it predicts is tied to a
/// parameter that they alone show, as to the first step of an axis, from which errors count. A fit to
/// the rest leaves it anywhere. None where that is true of all.
fn undetermined(
    context: &Context<'_>,
    keep: &[bool],
    chosen: &Selected<'_>,
    (fitted, fold): (&[usize], &[usize]),
    skip_groups: &[usize],
) -> Vec<usize> {
    let lin = Linear::of(&chosen.system, &chosen.estimate, keep, context.silent);
    let place = |group: &usize| fitted.iter().position(|f| f == group);
    let places: Vec<usize> = lin.cluster_groups.iter().filter_map(place).collect();
    if places.len() < lin.clusters.len() {
        return Vec::new();
    }
    let folds: Vec<usize> = places.iter().map(|&i| fold[i]).collect();
    let skip: Vec<bool> = lin.cluster_groups.iter().map(|g| skip_groups.contains(g)).collect();
    let errors = leave_out(&lin, &lin.basis, &folds, &skip);
    let judged = || places.iter().zip(&errors).zip(&skip).filter(|(_, skip)| !**skip);
    let open: Vec<usize> =
        judged().filter(|((_, error), _)| error.is_none()).map(|((i, _), _)| *i).collect();
    if open.len() < judged().count() { open } else { Vec::new() }
}

/// The choice made without some groups, and the errors of both models on them.
struct Repetition {
    added: Vec<What>,
    before: Vec<Option<GroupError>>,
    after: Vec<Option<GroupError>>,
}

fn repeat_without(
    context: &Context<'_>,
    keep: &[bool],
    base: &Estimate,
    chosen: &Selected<'_>,
    left_out: &[usize],
) -> Option<Repetition> {
    let declared = System::declared(context.model);
    let mut rest = keep.to_vec();
    for &g in left_out {
        rest[g] = false;
    }
    let rows = rows_of(&context.model.declared().layout, &rest);
    let without = declared.fit_anew(&rows, base).ok()?;
    let again = select(context, &rest, &without);
    Some(Repetition {
        before: reported_errors(&declared, &without, left_out),
        after: reported_errors(&again.system, &again.estimate, left_out),
        added: found_again(context, &rest, chosen, again),
    })
}

/// Reported squared error of each group of `groups`.
fn reported_errors(
    system: &System<'_>,
    at: &Estimate,
    groups: &[usize],
) -> Vec<Option<GroupError>> {
    let layout = &system.model.declared().layout;
    let all = system.residuals(at);
    let mut errors = vec![GroupError::default(); groups.len()];
    let mut place = vec![None; layout.groups.len()];
    for (i, &group) in groups.iter().enumerate() {
        place[group] = Some(i);
    }
    let mut last = None;
    for (row, r) in layout.rows.iter().enumerate() {
        let Some(i) = place[layout.observations[r.observation]] else { continue };
        errors[i].whitened += (all[row] / r.sigma).powi(2);
        if r.reported {
            errors[i].reported += all[row] * all[row];
            errors[i].observations += usize::from(last != Some(r.observation));
            last = Some(r.observation);
        }
    }
    errors.into_iter().map(|e| e.reported.is_finite().then_some(e)).collect()
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
