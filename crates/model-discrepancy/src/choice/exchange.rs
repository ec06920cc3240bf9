//! Whether other effects, no more in number or with far fewer amplitudes, describe the data better than
//! those that were added one by one.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::algebra::basis::{Basis, NEW_DIRECTION};
use crate::algebra::independent::Independent;
use crate::algebra::system::rows_of;
use crate::choice::additivity::not_additive;
use crate::choice::candidate::{Candidate, catalogue, classes};
use crate::choice::context::Context;
use crate::choice::score::{Scoring, home_of_bad};
use crate::choice::selected::{Added, Selected, What, cost, what, within_limits};
use crate::count::count;
use crate::levels::{CATALOGUE_SHARE, LATER, LEFT_BY_ANY, MIN_KEPT, WORTH_MENTIONING};
use crate::noise::linear::Linear;
use crate::tests::hold_out::{compare, leave_out};
use crate::tests::significance::{Reach, significance};

/// Most candidates of which all pairs are tried, the strongest alone first.
const MOST_CANDIDATES: usize = 40;
/// Amplitudes from which on two effects have half as many.
const WIDE: usize = 4;
/// Share of its norm that each column of a set must keep beside the others: two that nearly cancel would
/// have to be ten times as large as what they describe.
const APART: f64 = 0.1;
/// Sets that are fitted, the best description of the data first.
const MOST_FITTED: usize = 3;

/// Puts other effects in place of those that were named, where they describe the data clearly better;
/// false where nothing changed.
///
/// Added one by one, the first effect has to stand for all that is missing: of a squareness and an axis
/// that reads long it is a wider one that resembles both, and the next then makes up for what is wrong
/// with it. Tried are all single effects and all pairs, and of three and more also each one left out or
/// replaced; of one, as a deviation of its own at every place, those with half its amplitudes at most.
/// They are compared by the Bayesian information criterion in which all sets of a size are beforehand as likely
/// together as those of another (Chen and Chen 2008). Effects that live in one group, and shapes along
/// covariates, stay. Where a name is not what it promises, something outside the catalogue is missing, and
/// no other names from it are looked for.
pub(crate) fn exchange<'a>(
    context: &Context<'a>,
    keep: &[bool],
    chosen: &mut Selected<'a>,
) -> bool {
    let lin = Linear::of(&chosen.system, &chosen.estimate, keep, context.silent);
    let named: Vec<usize> = (chosen.system.active.iter().map(|a| a.effect))
        .filter(|&e| home_of_bad(context, &chosen.estimate, &lin, e).is_none())
        .collect();
    let amplitudes = |&e: &usize| context.model.declared().effects[e].parameters.len();
    let is_wide = named.iter().map(amplitudes).sum::<usize>() >= WIDE;
    if named.len() < 2 && !is_wide || !not_additive(context, chosen, &lin).is_empty() {
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
    let lin = Linear::of(&plain.system, &plain.estimate, keep, context.silent);
    let alpha = context.options.alpha * LATER * CATALOGUE_SHARE;
    let scoring = Scoring::new(context, &plain.system, &plain.estimate, &lin, alpha);
    let Some(sets) = Sets::of(&scoring, &plain, &named) else { return false };
    let own = sets.describe(&sets.own);
    let mut better: Vec<(Vec<usize>, Description)> = (sets.all().into_iter())
        .map(|set| {
            let description = sets.describe(&set);
            (set, description)
        })
        .filter(|(set, one)| sets.are_apart(set) && one.left > LEFT_BY_ANY)
        .filter(|(_, one)| named.len() > 1 || 2 * one.amplitudes <= own.amplitudes)
        .filter(|(_, one)| one.criterion(&sets) < own.criterion(&sets) - WORTH_MENTIONING)
        .collect();
    better.sort_by(|a, b| a.1.criterion(&sets).total_cmp(&b.1.criterion(&sets)));
    let before = cost(&chosen.system, &chosen.estimate, &rows);
    for (set, description) in better.into_iter().take(MOST_FITTED) {
        let Some(tests) = sets.needed(&set) else { continue };
        if !sets.predicts_no_worse(&set) {
            continue;
        }
        let system = set.iter().fold(plain.system.clone(), |s, &i| sets.candidates[i].added_to(&s));
        let Ok(fitted) = system.fit(&rows, &system.warm_start(&plain.estimate)) else { continue };
        let gain = sets.rows() * (cost(&system, &fitted, &rows) / before).ln();
        if gain + description.penalty - own.penalty >= -WORTH_MENTIONING
            || !within_limits(&system, &fitted)
        {
            continue;
        }
        let Ok(estimate) = system.reweighed(&rows, fitted) else { continue };
        let added = set.iter().zip(tests);
        plain
            .added
            .extend(added.map(|(&i, p_value)| Added { what: what(&sets.candidates[i]), p_value }));
        plain.system = system;
        plain.estimate = estimate;
        *chosen = plain;
        return true;
    }
    false
}

/// How well a set of candidates describes the data.
#[derive(Clone, Copy)]
struct Description {
    amplitudes: usize,
    /// Share of the squared residual that it leaves.
    left: f64,
    /// What its size costs.
    penalty: f64,
}

impl Description {
    /// Bayesian information criterion relative to none of them; lower is better.
    fn criterion(&self, sets: &Sets<'_, '_>) -> f64 {
        sets.rows() * self.left.max(f64::MIN_POSITIVE).ln() + self.penalty
    }
}

/// Candidates beside a system, of which sets are compared.
struct Sets<'a, 'b> {
    scoring: &'a Scoring<'b>,
    candidates: Vec<Candidate>,
    /// Those that were named.
    own: Vec<usize>,
    /// Which columns are each candidate's, and products of what the system leaves of these with each
    /// other and with the data.
    columns: Vec<Range<usize>>,
    products: DMatrix<f64>,
    onto: DVector<f64>,
}

impl<'a, 'b> Sets<'a, 'b> {
    /// One of each class, and all that were `named`; `None` where one of these is not seen.
    fn of(scoring: &'a Scoring<'b>, plain: &Selected<'b>, named: &[usize]) -> Option<Self> {
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
        let named_classes: Vec<usize> =
            (0..seen.len()).filter(|&i| is_named(&seen[i])).map(|i| class[i]).collect();
        let of_class =
            |i: usize| is_named(&seen[i]) || class[i] == i && !named_classes.contains(&class[i]);
        let keep: Vec<bool> = (0..seen.len()).map(of_class).collect();
        let mut kept = keep.iter();
        let mut candidates = seen;
        candidates.retain(|_| kept.next().copied().unwrap_or(false));
        let alone = |c: &Candidate| {
            let basis = Basis::of(&c.beside, NEW_DIRECTION.sqrt());
            (!is_named(c), -basis.explained(&scoring.clean))
        };
        let mut ranked: Vec<_> = candidates.into_iter().map(|c| (alone(&c), c)).collect();
        ranked.sort_by(|(a, _), (b, _)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        ranked.truncate(MOST_CANDIDATES);
        let candidates: Vec<Candidate> = ranked.into_iter().map(|(_, c)| c).collect();
        let own: Vec<usize> = (0..candidates.len()).filter(|&i| is_named(&candidates[i])).collect();
        if own.len() < named.len() {
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
        let products = beside.transpose() * &beside;
        let onto = beside.tr_mul(&scoring.clean);
        Some(Self { scoring, candidates, own, columns, products, onto })
    }

    fn rows(&self) -> f64 {
        count(self.scoring.lin.rows.len())
    }

    /// Every set that is tried.
    fn all(&self) -> Vec<Vec<usize>> {
        let n = self.candidates.len();
        let mut sets: Vec<Vec<usize>> = (0..n).map(|i| vec![i]).collect();
        sets.extend((0..n).flat_map(|i| (i + 1..n).map(move |j| vec![i, j])));
        if self.own.len() > 2 {
            for at in 0..self.own.len() {
                let mut rest = self.own.clone();
                rest.remove(at);
                let others = (0..n).filter(|i| !self.own.contains(i));
                sets.extend(others.map(|i| rest.iter().copied().chain([i]).collect()));
                sets.push(rest);
            }
        }
        sets
    }

    /// Whether the effects keep enough of their columns beside those before them.
    fn are_apart(&self, set: &[usize]) -> bool {
        let products = self.products_of(set);
        let first = self.columns[set[0]].len();
        let kept = |column: usize| if column < first { MIN_KEPT } else { APART };
        let new = Independent::of(&products, |c| kept(c).powi(2) * products[(c, c)]);
        let more = new.kept.iter().filter(|c| **c >= first).count();
        first + more == products.ncols()
    }

    fn describe(&self, set: &[usize]) -> Description {
        let searched: f64 = set.iter().map(|&i| self.candidates[i].searched.ln()).sum();
        let products = self.products_of(set);
        let new = Independent::of(&products, |c| MIN_KEPT * MIN_KEPT * products[(c, c)]);
        let columns = set.iter().flat_map(|&i| self.columns[i].clone());
        let onto = DVector::from_iterator(products.ncols(), columns.map(|c| self.onto[c]));
        let square = self.scoring.clean.norm_squared();
        let left = (square - new.along_one(&onto).norm_squared()).max(0.0) / square;
        let (amplitudes, of_size) = (new.kept.len(), ways(self.candidates.len(), set.len()));
        let penalty = count(amplitudes) * self.rows().ln() + 2.0 * (searched + of_size.ln());
        Description { amplitudes, left, penalty }
    }

    /// Products of the columns of a set.
    fn products_of(&self, set: &[usize]) -> DMatrix<f64> {
        let columns: Vec<usize> = set.iter().flat_map(|&i| self.columns[i].clone()).collect();
        let n = columns.len();
        DMatrix::from_fn(n, n, |i, j| self.products[(columns[i], columns[j])])
    }

    /// The significance of each beside the others, where each is as significant as what a later pass
    /// adds has to be.
    fn needed(&self, set: &[usize]) -> Option<Vec<f64>> {
        let lin = self.scoring.lin;
        let level = self.scoring.alpha / count(self.candidates.len());
        let one = |&i: &usize| {
            let others = set.iter().filter(|&&j| j != i);
            let base = others.fold(lin.basis.clone(), |base, &j| {
                base.with(&self.candidates[j].tangent, NEW_DIRECTION)
            });
            let candidate = &self.candidates[i];
            let test = significance(lin, &base, &candidate.tangent, candidate.reach, level)?;
            (test.p_value * candidate.searched <= level).then_some(test.p_value)
        };
        set.iter().map(one).collect()
    }

    /// Whether groups left out are predicted as well as by what was named, to a standard error.
    fn predicts_no_worse(&self, set: &[usize]) -> bool {
        let Scoring { lin, folds, skip, .. } = self.scoring;
        let held_out = |set: &[usize]| {
            let full = set.iter().fold(lin.basis.clone(), |base, &i| {
                base.with(&self.candidates[i].tangent, NEW_DIRECTION)
            });
            leave_out(lin, &full, folds, skip)
        };
        let comparison = compare(&held_out(&self.own), &held_out(set), skip);
        comparison.difference <= comparison.std
    }
}

/// Number of sets of a size.
fn ways(of: usize, size: usize) -> f64 {
    (0..size).map(|k| count(of.saturating_sub(k).max(1)) / count(k + 1)).product()
}
