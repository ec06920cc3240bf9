//! Errors on groups that no fit and no choice has seen.

use rayon::prelude::*;

use crate::algebra::system::{Estimate, System, rows_of};
use crate::answer::confounded::Attribution;
use crate::answer::found_again::{found_again, shares};
use crate::choice::blocks::{Blocks, WithoutBlock};
use crate::choice::context::Context;
use crate::choice::select::select;
use crate::choice::selected::{Selected, What};
use crate::levels::{CHOICE_FOLDS, MIN_NESTED_GROUPS, STEADY};
use crate::noise::linear::Linear;
use crate::tests::hold_out::{GroupError, folds, leave_out};
use crate::{HoldOut, Role};

/// Repetitions of the choice at most; each leaves out every so-manieth group.
const MAX_NESTED_FOLDS: usize = 24;

/// What groups that were left out say of both models.
pub(crate) struct Unseen {
    pub(crate) hold_out: HoldOut,
    /// Of the declared model and of the final one, by group.
    pub(crate) errors: [Vec<Option<GroupError>>; 2],
    /// How often each addition is found again.
    pub(crate) found_again: Vec<Option<f64>>,
    /// Groups by their place in `errors` without which something else was chosen, where nearly all
    /// repetitions agree: what these predict speaks of another model.
    pub(crate) strays: Vec<usize>,
}

/// Errors of both models on groups that were left out, and how often each addition is found again.
pub(crate) fn unseen_errors(
    context: &Context<'_>,
    keep: &[bool],
    declared: (&Estimate, &Linear<'_>),
    (chosen, lin): (&Selected<'_>, &Linear<'_>),
    attributions: &[Option<Attribution<'_>>],
    skip_groups: &[usize],
) -> Unseen {
    let groups = &context.model.declared().layout.groups;
    let checks: Vec<_> = (0..groups.len()).filter(|&g| groups[g].role == Role::Check).collect();
    let fitted: Vec<_> = (0..groups.len()).filter(|&g| keep[g]).collect();
    let nested = context.options.nested && fitted.len() >= MIN_NESTED_GROUPS;
    let repeated = (nested && (checks.is_empty() || !chosen.added.is_empty())).then(|| {
        let folds = NestedFolds::of(&fitted, skip_groups);
        nested_errors(context, keep, declared, (chosen, lin), attributions, (&fitted, &folds))
    });
    if !checks.is_empty() {
        let before = reported_errors(&System::declared(context.model), declared.0, &checks);
        let after = reported_errors(&chosen.system, &chosen.estimate, &checks);
        let found_again = repeated.map_or(vec![None; chosen.added.len()], |r| r.found_again);
        let (hold_out, errors) = (HoldOut::CheckGroups, [before, after]);
        return Unseen { hold_out, errors, found_again, strays: Vec::new() };
    }
    repeated.unwrap_or_else(|| Unseen {
        hold_out: HoldOut::LeaveOneOut,
        errors: [declared.1, lin].map(|lin| one_by_one(lin, skip_groups)),
        found_again: vec![None; chosen.added.len()],
        strays: Vec::new(),
    })
}

/// Errors of the declared model alone on groups that were left out, as [`unseen_errors`] has them.
pub(crate) fn unseen_before(
    context: &Context<'_>,
    keep: &[bool],
    (base, of_declared): (&Estimate, &Linear<'_>),
    lin: &Linear<'_>,
    skip_groups: &[usize],
) -> (HoldOut, Vec<Option<GroupError>>) {
    let groups = &context.model.declared().layout.groups;
    let declared = System::declared(context.model);
    let checks: Vec<_> = (0..groups.len()).filter(|&g| groups[g].role == Role::Check).collect();
    if !checks.is_empty() {
        return (HoldOut::CheckGroups, reported_errors(&declared, base, &checks));
    }
    let fitted: Vec<_> = (0..groups.len()).filter(|&g| keep[g]).collect();
    if !context.options.nested || fitted.len() < MIN_NESTED_GROUPS {
        return (HoldOut::LeaveOneOut, one_by_one(of_declared, skip_groups));
    }
    let folds = NestedFolds::of(&fitted, skip_groups);
    let mut errors = vec![None; fitted.len()];
    let open = undetermined(lin, &fitted, &folds);
    for (members, left_out) in folds.members.iter().zip(&folds.left_out) {
        let Some((_, without)) = declared_without(&declared, keep, base, left_out) else {
            continue;
        };
        let reported = reported_errors(&declared, &without, left_out);
        for (&i, error) in members.iter().zip(reported).filter(|(i, _)| !open.contains(i)) {
            errors[i] = error;
        }
    }
    (HoldOut::Nested, errors)
}

/// Error of each cluster, left out in turn of a linearised system.
fn one_by_one(lin: &Linear<'_>, skip_groups: &[usize]) -> Vec<Option<GroupError>> {
    let skip: Vec<_> = lin.cluster_groups.iter().map(|g| skip_groups.contains(g)).collect();
    leave_out(lin, &lin.basis, &folds(lin.clusters.len(), CHOICE_FOLDS), &skip)
}

/// What is left out together while the choice is repeated.
struct NestedFolds {
    /// Fold of each fitted group, and whether it stays in every fit.
    of_each: Vec<usize>,
    is_skipped: Vec<bool>,
    /// Positions among the fitted groups of those that each fold leaves out, and their numbers.
    members: Vec<Vec<usize>>,
    left_out: Vec<Vec<usize>>,
}

impl NestedFolds {
    fn of(fitted: &[usize], skip_groups: &[usize]) -> Self {
        let of_each = folds(fitted.len(), MAX_NESTED_FOLDS);
        let is_skipped: Vec<bool> = fitted.iter().map(|g| skip_groups.contains(g)).collect();
        let is_member = |f: usize, i: &usize| of_each[*i] == f && !is_skipped[*i];
        let of_fold = |f| (0..fitted.len()).filter(|i| is_member(f, i)).collect();
        let n = of_each.iter().max().map_or(0, |f| f + 1);
        let members: Vec<Vec<usize>> = (0..n).map(of_fold).collect();
        let left_out = members.iter().map(|m| m.iter().map(|&i| fitted[i]).collect()).collect();
        Self { of_each, is_skipped, members, left_out }
    }
}

/// Repeats the whole choice without each fold and predicts the fold.
fn nested_errors(
    context: &Context<'_>,
    keep: &[bool],
    declared: (&Estimate, &Linear<'_>),
    (chosen, lin): (&Selected<'_>, &Linear<'_>),
    attributions: &[Option<Attribution<'_>>],
    (fitted, folds): (&[usize], &NestedFolds),
) -> Unseen {
    let progress = &context.options.progress;
    progress.expect(folds.members.len());
    let blocks = seen_in_blocks(context, declared, (chosen, lin), &folds.left_out);
    // Each repetition stands alone, so the answer does not depend on the number of threads.
    let repetitions: Vec<_> = (0..folds.members.len())
        .into_par_iter()
        .filter_map(|block| {
            let known = WithoutBlock { blocks: &blocks, block };
            let quick = Context { thorough: false, without_block: Some(known), ..*context };
            let repetition =
                repeat_without(&quick, keep, declared.0, chosen, &folds.left_out[block]);
            progress.done();
            Some((&folds.members[block], repetition?))
        })
        .collect();
    let mut errors = [vec![None; fitted.len()], vec![None; fitted.len()]];
    let open = undetermined(lin, fitted, folds);
    for (members, repetition) in &repetitions {
        for (k, &i) in members.iter().enumerate().filter(|(_, i)| !open.contains(i)) {
            errors[0][i] = repetition.before[k];
            errors[1][i] = repetition.after[k];
        }
    }
    let (members, choices): (Vec<_>, Vec<_>) =
        repetitions.into_iter().map(|(members, r)| (members, r.added)).unzip();
    let found_again = shares(chosen, attributions, &choices);
    let is_steady = found_again.iter().flatten().all(|share| *share >= STEADY);
    let is_other = |choice: &Vec<What>| {
        shares(chosen, attributions, std::slice::from_ref(choice)).contains(&Some(0.0))
    };
    let others =
        members.into_iter().zip(&choices).filter(|(_, choice)| is_steady && is_other(choice));
    let strays = others.flat_map(|(members, _)| members.iter().copied()).collect();
    Unseen { hold_out: HoldOut::Nested, errors, found_again, strays }
}

/// The declared model, and the chosen one, by sums over the blocks that are left out.
fn seen_in_blocks<'a>(
    context: &Context<'a>,
    declared: (&Estimate, &Linear<'_>),
    (chosen, lin): (&Selected<'a>, &Linear<'_>),
    left_out: &[Vec<usize>],
) -> Vec<Blocks<'a>> {
    let plain = System::declared(context.model);
    let along = (context.covariates, context.shapes);
    let of = |system: &System<'a>, (at, lin): (&Estimate, &Linear<'_>)| {
        Blocks::of(along, context.banned, (system, at), lin, left_out)
    };
    let systems = [(&plain, declared), (&chosen.system, (&chosen.estimate, lin))];
    let different = if chosen.system.is_same(&plain) { 1 } else { 2 };
    systems[..different].iter().filter_map(|(system, at)| of(system, *at)).collect()
}

/// Groups of which the chosen model predicts nothing from the others: what it predicts is tied to a
/// parameter that they alone show, as to the first step of an axis, from which errors count. A fit to
/// the rest leaves it anywhere. None where that is true of all.
fn undetermined(lin: &Linear<'_>, fitted: &[usize], folds: &NestedFolds) -> Vec<usize> {
    let mut place = vec![None; lin.layout.groups.len()];
    for (i, &group) in fitted.iter().enumerate() {
        place[group] = Some(i);
    }
    let places: Vec<usize> = lin.cluster_groups.iter().filter_map(|&group| place[group]).collect();
    if places.len() < lin.clusters.len() {
        return Vec::new();
    }
    let of_each: Vec<usize> = places.iter().map(|&i| folds.of_each[i]).collect();
    let skip: Vec<bool> = places.iter().map(|&i| folds.is_skipped[i]).collect();
    let errors = leave_out(lin, &lin.basis, &of_each, &skip);
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
    let (rest, without) = declared_without(&declared, keep, base, left_out)?;
    let again = select(context, &rest, &without);
    Some(Repetition {
        before: reported_errors(&declared, &without, left_out),
        after: reported_errors(&again.system, &again.estimate, left_out),
        added: found_again(context, &rest, chosen, again),
    })
}

/// The groups that stay, and the declared model as fitted to them.
fn declared_without(
    declared: &System<'_>,
    keep: &[bool],
    base: &Estimate,
    left_out: &[usize],
) -> Option<(Vec<bool>, Estimate)> {
    let mut rest = keep.to_vec();
    for &g in left_out {
        rest[g] = false;
    }
    let rows = rows_of(&declared.model.declared().layout, &rest);
    let without = declared.fit_anew(&rows, base).ok()?;
    Some((rest, without))
}

/// Reported squared error of each group of `groups`.
pub(crate) fn reported_errors(
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
