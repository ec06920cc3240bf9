//! One cause in place of several names that describe the data no better.

use crate::algebra::system::rows_of;
use crate::choice::addition::{add, cost, what};
use crate::choice::candidate::Source;
use crate::choice::context::Context;
use crate::choice::ranking::{Confirmed, eligible, ranked};
use crate::choice::score::{Scored, Scoring, score_catalogue, score_covariates};
use crate::choice::selected::{Selected, What};
use crate::choice::shape::is_of_levels;
use crate::count::count;
use crate::levels::{CATALOGUE_SHARE, LATER, QUARTER, TIE, WORTH_MENTIONING};
use crate::noise::linear::Linear;
use crate::tests::significance::Reach;

/// Most names of which each two are taken for one.
const MOST_NAMES: usize = 4;

/// Puts a single effect in place of several that describe the data no better: what went first may have
/// been but the best part of it, and what followed the rest.
pub(crate) fn replaced_by_effect<'a>(
    context: &Context<'a>,
    keep: &[bool],
    chosen: &mut Selected<'a>,
) -> bool {
    let effects: Vec<usize> = chosen.system.active.iter().map(|a| a.effect).collect();
    let one = several(&effects).into_iter().find_map(|names| by_one(context, keep, chosen, &names));
    let Some(one) = one else { return false };
    *chosen = one;
    true
}

/// All names, then each two of them.
fn several(effects: &[usize]) -> Vec<Vec<usize>> {
    if effects.len() < 2 {
        return Vec::new();
    }
    let mut sets = vec![effects.to_vec()];
    if (3..=MOST_NAMES).contains(&effects.len()) {
        for (k, &first) in effects.iter().enumerate() {
            sets.extend(effects[k + 1..].iter().map(|&second| vec![first, second]));
        }
    }
    sets
}

/// The selection with one effect in place of these; `None` where none is as good.
fn by_one<'a>(
    context: &Context<'a>,
    keep: &[bool],
    chosen: &Selected<'a>,
    names: &[usize],
) -> Option<Selected<'a>> {
    let plain = without_names(context, keep, chosen, names)?;
    let lin = Linear::of(&plain.system, &plain.estimate, keep, context.silent);
    let most = described(context, keep, chosen, (&plain, &lin)).0 + TIE;
    let alpha = context.options.alpha * LATER * CATALOGUE_SHARE;
    let scoring = Scoring::new(context, &plain.system, &plain.estimate, &lin, alpha);
    let mut pass = score_catalogue(&plain.system, &plain.estimate, &scoring);
    let is_another = |j: &Scored| {
        let is_one_of_them = names.iter().any(|&name| what(&j.candidate) == What::Effect(name));
        j.candidate.reach == Reach::Many && !is_one_of_them
    };
    pass.judged.retain(|j| is_another(j) && j.criterion <= most);
    let order = ranked(&scoring, &mut pass.judged, Confirmed::First);
    let best = order.first().map(|&i| &pass.judged[i])?;
    let mut one = plain.clone();
    // The fit has the last word: it moves farther than tangents say.
    let stands =
        add(&mut one, keep, &[best]) && described(context, keep, &one, (&plain, &lin)).0 <= most;
    stands.then_some(one)
}

/// Whether a single shape along a covariate describes the data better than two named effects.
pub(crate) fn one_shape_is_better(
    context: &Context<'_>,
    scoring: &Scoring<'_>,
    pair: &[Scored; 2],
) -> bool {
    better_shape(context, scoring, (pair[0].criterion, 0), |_| true).is_some()
}

/// The shape along a covariate that describes the data best of those whose names `counts`, where it
/// does so clearly better than effects of this criterion and so many directions; with no more
/// directions than these, where it does so no worse.
fn better_shape(
    context: &Context<'_>,
    scoring: &Scoring<'_>,
    (than, directions): (f64, usize),
    counts: impl Fn(&str) -> bool,
) -> Option<Scored> {
    let judged = score_covariates(context, scoring);
    let order = eligible(&judged, context.options.alpha * QUARTER);
    let n = count(scoring.lin.rows.len());
    let before = scoring.lin.clean_residual().norm_squared();
    let criterion = |judged: &Scored| {
        let Source::Empirical(shape) = &judged.candidate.source else { return f64::INFINITY };
        if !counts(&shape.shape) {
            return f64::INFINITY;
        }
        let left = (judged.test.variance * count(judged.test.dof) / before).max(f64::MIN_POSITIVE);
        let (free, own) = (judged.test.directions, shape.constants);
        if free <= directions {
            // As many laws as levels: they pass through any values, and their names say nothing.
            return n * left.ln() + count(free) * n.ln() - 2.0 * WORTH_MENTIONING;
        }
        // Unlike effects, a shape brings its constants along: they count here.
        n * left.ln() + count(free + own) * n.ln()
    };
    let all = order.iter().map(|&i| (criterion(&judged[i]), i));
    let (best, i) = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (best < than - WORTH_MENTIONING).then(|| judged[i].clone())
}

/// Puts a shape of levels in place of two named effects where it describes the data better: two laws
/// of a load pass through any three loads, and say nothing where one of the loads went otherwise.
pub(crate) fn replaced_by_shape<'a>(
    context: &Context<'a>,
    keep: &[bool],
    chosen: &mut Selected<'a>,
) -> bool {
    let effects: Vec<usize> = chosen.system.active.iter().map(|a| a.effect).collect();
    if effects.len() != 2 {
        return false;
    }
    let Some(mut plain) = without_names(context, keep, chosen, &effects) else { return false };
    let lin = Linear::of(&plain.system, &plain.estimate, keep, context.silent);
    let than = described(context, keep, chosen, (&plain, &lin));
    let alpha = context.options.alpha * QUARTER;
    let scoring = Scoring::new(context, &plain.system, &plain.estimate, &lin, alpha);
    let Some(shape) = better_shape(context, &scoring, than, is_of_levels) else { return false };
    if !add(&mut plain, keep, &[&shape]) {
        return false;
    }
    plain.passes.clone_from(&chosen.passes);
    *chosen = plain;
    true
}

/// The selection without these names, fitted anew.
fn without_names<'a>(
    context: &Context<'a>,
    keep: &[bool],
    chosen: &Selected<'a>,
    names: &[usize],
) -> Option<Selected<'a>> {
    let mut plain = chosen.clone();
    for &name in names {
        plain.system = plain.system.without_effect(name);
        plain.added.retain(|a| a.what != What::Effect(name));
    }
    let rows = rows_of(&context.model.declared().layout, keep);
    let start = plain.system.warm_start(&chosen.estimate);
    plain.estimate = plain.system.fit(&rows, &start).ok()?;
    Some(plain)
}

/// Bayesian information criterion of what a selection has more than a plain one, and its directions.
fn described(
    context: &Context<'_>,
    keep: &[bool],
    chosen: &Selected<'_>,
    (plain, lin): (&Selected<'_>, &Linear<'_>),
) -> (f64, usize) {
    let named = Linear::of(&chosen.system, &chosen.estimate, keep, context.silent);
    let rows = rows_of(&context.model.declared().layout, keep);
    let left =
        cost(&chosen.system, &chosen.estimate, &rows) / cost(&plain.system, &plain.estimate, &rows);
    let directions = named.basis.dim().saturating_sub(lin.basis.dim());
    let n = count(lin.rows.len());
    let looked_at = |selected: &Selected<'_>| -> f64 {
        let effects = &context.model.declared().effects;
        selected.system.active.iter().map(|a| count(effects[a.effect].searched).ln()).sum()
    };
    let searched = 2.0 * (looked_at(chosen) - looked_at(plain));
    (n * left.max(f64::MIN_POSITIVE).ln() + count(directions) * n.ln() + searched, directions)
}
