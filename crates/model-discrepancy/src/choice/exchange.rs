//! Whether other effects, no more in number or with far fewer amplitudes, describe the data better than
//! those that were added one by one.

use nalgebra::DMatrix;

use crate::algebra::basis::{Basis, NEW_DIRECTION};
use crate::algebra::product::gram;
use crate::algebra::system::rows_of;
use crate::choice::additivity::not_additive;
use crate::choice::candidate::{Candidate, Source, catalogue, classes};
use crate::choice::context::Context;
use crate::choice::score::{Scoring, home_of_bad};
use crate::choice::selected::{Added, Selected, What, cost, what, within_limits};
use crate::choice::sets::{Member, Sets, tried};
use crate::count::count;
use crate::levels::{CATALOGUE_SHARE, GROSS_SCATTER, LATER, WORTH_MENTIONING};
use crate::tests::global_test::global_test;
use crate::tests::hold_out::{compare, leave_out};
use crate::tests::significance::{Reach, significance};

/// Numbers of an effect, amplitudes and what was fitted in looking for it, from which on two effects have
/// half as many.
const WIDE: usize = 4;
/// Sets that are fitted, the best description of the data first.
const MOST_FITTED: usize = 3;

/// Puts other effects in place of those that were named, where they describe the data clearly better;
/// false where nothing changed.
///
/// Added one by one, the first effect has to stand for all that is missing: of a squareness and an axis
/// that reads long it is a wider one that resembles both, and the next then makes up for what is wrong
/// with it. Tried are all single effects and all pairs, and of three and more also any one or two of them left
/// out or replaced; of one, as a deviation of its own at every place, or a drift with a time constant of its
/// own, those with half its numbers at most.
/// An effect that is looked for [only instead](crate::Effect::only_instead) takes the place of more than it is put in with.
/// They are compared by the Bayesian information criterion in which all sets of a size are beforehand as likely
/// together as those of another (Chen and Chen 2008). Effects that live in one group, and shapes along
/// covariates, stay. Where a name is not what it promises, something outside the catalogue is missing, and
/// no other names from it are looked for.
pub(crate) fn exchange<'a>(
    context: &Context<'a>,
    keep: &[bool],
    chosen: &mut Selected<'a>,
) -> bool {
    let numbers = |&e: &usize| {
        let effect = &context.model.declared().effects[e];
        effect.parameters.len() + effect.coordinates()
    };
    let may_be =
        |named: &[usize]| named.len() > 1 || named.iter().map(numbers).sum::<usize>() >= WIDE;
    let all: Vec<usize> = chosen.system.active.iter().map(|a| a.effect).collect();
    if !may_be(&all) || !context.without_block.is_none_or(|known| known.sets_may_be(chosen)) {
        return false;
    }
    let lin = context.linear(&chosen.system, &chosen.estimate, keep);
    // In a repetition what leaves ten times the noise is not found again for what it is, and fits of it take
    // long.
    let is_gross = || {
        let test = global_test(&chosen.system, &chosen.estimate, &lin);
        test.is_some_and(|test| test.per_dof() >= GROSS_SCATTER)
    };
    if !context.thorough && is_gross() {
        return false;
    }
    let named: Vec<usize> = (chosen.system.active.iter().map(|a| a.effect))
        .filter(|&e| home_of_bad(context, &chosen.estimate, &lin, e).is_none())
        .collect();
    if !may_be(&named) || !not_additive(context, chosen, &lin).is_empty() {
        return false;
    }
    let mut plain = chosen.clone();
    for &effect in &named {
        plain.system = plain.system.without_effect(effect);
    }
    plain.added.retain(|a| !named.iter().any(|&e| a.what == What::Effect(e)));
    let rows = rows_of(&context.model.declared().layout, keep);
    let start = plain.system.warm_start(&chosen.estimate);
    let Ok(estimate) = plain.system.fit(&rows, &start) else { return false };
    plain.estimate = estimate;
    let lin = context.linear(&plain.system, &plain.estimate, keep);
    let alpha = context.options.alpha * LATER * CATALOGUE_SHARE;
    let scoring = Scoring::new(context, &plain.system, &plain.estimate, &lin, alpha);
    let Some((candidates, sets)) = sets_of(&scoring, &plain, &named) else { return false };
    let own = sets.of_named();
    let before = cost(&chosen.system, &chosen.estimate, &rows);
    let effects = &context.model.declared().effects;
    let only_instead =
        |&i: &usize| matches!(what(&candidates[i]), What::Effect(e) if effects[e].only_instead);
    let may_be_set = |set: &[usize]| set.len() < named.len() || !set.iter().any(only_instead);
    let better = sets.better().into_iter().filter(|(set, _)| may_be_set(set));
    for (set, description) in better.take(MOST_FITTED) {
        let members: Vec<&Candidate> = set.iter().map(|&i| &candidates[i]).collect();
        let level = scoring.alpha / count(candidates.len());
        let Some(tests) = needed(&scoring, &members, level) else { continue };
        if !predicts_no_worse(&scoring, &candidates[..sets.named], &members) {
            continue;
        }
        let system = members.iter().fold(plain.system.clone(), |s, one| one.added_to(&s));
        let Ok(fitted) = system.fit(&rows, &system.warm_start(&plain.estimate)) else { continue };
        let gain = count(sets.rows) * (cost(&system, &fitted, &rows) / before).ln();
        if gain + description.penalty - own.penalty >= -WORTH_MENTIONING
            || !within_limits(&system, &fitted)
        {
            continue;
        }
        let Ok(estimate) = system.reweighed(&rows, fitted) else { continue };
        let added = members.iter().zip(tests);
        plain.added.extend(added.map(|(one, p_value)| Added { what: what(one), p_value }));
        plain.system = system;
        plain.estimate = estimate;
        *chosen = plain;
        return true;
    }
    false
}

/// The candidates of which sets are tried, and these; `None` where one of the named is not seen.
fn sets_of(
    scoring: &Scoring<'_>,
    plain: &Selected<'_>,
    named: &[usize],
) -> Option<(Vec<Candidate>, Sets)> {
    let lin = scoring.lin;
    let open = catalogue(&plain.system, &plain.estimate, lin)
        .into_iter()
        .filter(|(e, _)| !scoring.banned.contains(e));
    let seen: Vec<Candidate> = open
        .filter_map(|(_, sight)| sight.candidate())
        .filter(|c| c.reach == Reach::Many)
        .collect();
    let class = classes(&seen);
    let is_named = |c: &Candidate| named.iter().any(|&e| what(c) == What::Effect(e));
    let member = |(c, class): (&Candidate, usize)| Member {
        class,
        is_named: is_named(c),
        explained: Basis::of(&c.beside, NEW_DIRECTION.sqrt()).explained(&scoring.clean),
    };
    let members: Vec<Member> = seen.iter().zip(class).map(member).collect();
    let candidates: Vec<Candidate> = tried(&members).into_iter().map(|i| seen[i].clone()).collect();
    if candidates.iter().filter(|c| is_named(c)).count() < named.len() {
        return None;
    }
    let mut next = 0;
    let columns = candidates.iter().map(|candidate| {
        let start = next;
        next += candidate.beside.ncols();
        start..next
    });
    let columns = columns.collect();
    let beside: Vec<_> = candidates.iter().flat_map(|c| c.beside.column_iter()).collect();
    let beside = DMatrix::from_columns(&beside);
    let sets = Sets {
        searched: candidates.iter().map(|c| c.searched).collect(),
        coordinates: candidates.iter().map(|c| coordinates(plain, c)).collect(),
        named: named.len(),
        columns,
        products: gram(&beside),
        onto: beside.tr_mul(&scoring.clean),
        square: scoring.clean.norm_squared(),
        rows: lin.rows.len(),
    };
    Some((candidates, sets))
}

fn coordinates(plain: &Selected<'_>, candidate: &Candidate) -> usize {
    let effects = &plain.system.model.declared().effects;
    match &candidate.source {
        Source::Effect(active) => effects[active.effect].coordinates(),
        Source::Empirical(_) => 0,
    }
}

/// The significance of each beside the others, where each is as significant as what a later pass
/// adds has to be.
fn needed(scoring: &Scoring<'_>, set: &[&Candidate], level: f64) -> Option<Vec<f64>> {
    let lin = scoring.lin;
    let one = |(i, candidate): (usize, &&Candidate)| {
        let others = set.iter().enumerate().filter(|(j, _)| *j != i);
        let base = others
            .fold(lin.basis.clone(), |base, (_, other)| base.with(&other.tangent, NEW_DIRECTION));
        let test = significance(lin, &base, &candidate.tangent, candidate.reach, level)?;
        (test.p_value * candidate.searched <= level).then_some(test.p_value)
    };
    set.iter().enumerate().map(one).collect()
}

/// Whether groups left out are predicted as well as by what was named, to a standard error.
fn predicts_no_worse(scoring: &Scoring<'_>, named: &[Candidate], set: &[&Candidate]) -> bool {
    let Scoring { lin, folds, skip, .. } = scoring;
    let held_out = |set: &mut dyn Iterator<Item = &Candidate>| {
        let full = set.fold(lin.basis.clone(), |base, one| base.with(&one.tangent, NEW_DIRECTION));
        leave_out(lin, &full, folds, skip)
    };
    let (before, after) = (held_out(&mut named.iter()), held_out(&mut set.iter().copied()));
    let comparison = compare(&before, &after, skip);
    comparison.difference <= comparison.std
}
