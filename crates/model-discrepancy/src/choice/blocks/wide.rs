//! Effects that move many observations, without a block of groups.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::Scope;
use crate::algebra::independent::Independent;
use crate::algebra::product::gram;
use crate::algebra::system::{Estimate, System};
use crate::choice::beside::Beside;
use crate::choice::blocks::passing::{One, Passing};
use crate::choice::blocks::rows::Rows;
use crate::choice::candidate::{min_kept, same_directions};
use crate::choice::sets::{Member, Sets, tried};
use crate::count::count;
use crate::levels::{CATALOGUE_SHARE, LEFT_BY_ANY, MAX_CLASSES, QUARTER};
use crate::model::whole_tangent;
use crate::noise::linear::Linear;
use crate::tests::f_test::{Significance, f_test_of};

/// Share of its length that a direction of one effect must keep beside another to be one of both.
const NEW_BESIDE: f64 = 1e-5;

/// Share of a column's square, all rows taken together, below which its square without a block is
/// round-off: the block alone shows it.
const ROUND_OFF: f64 = 1e-12;

/// Every effect that moves many observations.
pub(super) struct Wide {
    effects: Vec<Open>,
    /// Directions of the system.
    directions: usize,
    /// Products of the directions, of what they leave of the effects' columns, and of what they leave
    /// of the data, over all rows; and the squares of the whole columns.
    all: (DMatrix<f64>, DVector<f64>),
    /// The same over the rows of each block.
    blocks: Vec<(DMatrix<f64>, DVector<f64>)>,
    /// Clusters in each block.
    members: Vec<Vec<usize>>,
}

struct Open {
    effect: usize,
    id: String,
    has_subject: bool,
    only_instead: bool,
    searched: f64,
    coordinates: usize,
    min_kept: f64,
    columns: Range<usize>,
    /// Clusters that each column moves; `None` of more than a block can leave one of.
    moved: Vec<Option<Vec<usize>>>,
}

/// An effect that is seen without a block.
struct Seen<'a> {
    one: &'a Open,
    /// Along its orthonormal directions.
    data: DVector<f64>,
    /// These, as combinations of all effects' columns: the rows of its own.
    columns: Vec<usize>,
    factor: DMatrix<f64>,
    /// Whether it lives in one cluster.
    is_local: bool,
    test: Significance,
}

impl Wide {
    pub(super) fn of(
        banned: &[usize],
        (system, at): (&System<'_>, &Estimate),
        lin: &Linear<'_>,
        (directions, clean): (&DMatrix<f64>, &DVector<f64>),
        rows: &[Rows],
    ) -> Self {
        let declared = system.model.declared();
        let is_open = |e: &usize| {
            let is_wide = !matches!(declared.effects[*e].scope, Scope::Observation(_));
            is_wide && !system.has_effect(*e) && !banned.contains(e)
        };
        let open: Vec<usize> = (0..declared.effects.len()).filter(is_open).collect();
        let tangent = |&e: &usize| lin.tangent(&whole_tangent(system.model, &at.state, e));
        let tangents: Vec<DMatrix<f64>> = open.iter().map(tangent).collect();
        let members: Vec<Vec<usize>> = rows.iter().map(|rows| rows.clusters.clone()).collect();
        let most = members.iter().map(Vec::len).max().unwrap_or(0) + 1;
        let mut next = 0;
        let effects = open.iter().zip(&tangents).map(|(&e, tangent)| {
            let effect = &declared.effects[e];
            let columns = next..next + tangent.ncols();
            next = columns.end;
            let has_subject = effect.subject.is_some();
            let moved = tangent.column_iter().map(|column| {
                let is_moved = |c: &usize| lin.clusters[*c].iter().any(|&row| column[row] != 0.0);
                let clusters = || (0..lin.clusters.len()).filter(is_moved).take(most + 1);
                has_subject.then(|| clusters().collect()).filter(|m: &Vec<usize>| m.len() <= most)
            });
            Open {
                effect: e,
                id: effect.id.clone(),
                has_subject,
                only_instead: effect.only_instead,
                searched: count(effect.searched.max(1)),
                coordinates: effect.coordinates(),
                min_kept: min_kept(effect),
                columns,
                moved: moved.collect(),
            }
        });
        let effects: Vec<Open> = effects.collect();
        let columns: Vec<_> = tangents.iter().flat_map(DMatrix::column_iter).collect();
        let whole = if columns.is_empty() {
            DMatrix::zeros(lin.rows.len(), 0)
        } else {
            DMatrix::from_columns(&columns)
        };
        let left = lin.basis.reject_columns(&whole);
        let columns = directions.column_iter().chain(left.column_iter()).chain(clean.column_iter());
        let all = DMatrix::from_columns(&columns.collect::<Vec<_>>());
        let sums = |some: &Rows| {
            let (all, whole) = (all.select_rows(&some.some), whole.select_rows(&some.some));
            let squares = whole.column_iter().map(|column| column.norm_squared());
            let squares = DVector::from_iterator(whole.ncols(), squares);
            (gram(&all), squares)
        };
        let blocks: Vec<_> = rows.iter().map(sums).collect();
        let is_of_none = |row: &usize| !rows.iter().any(|rows| rows.is_one[*row]);
        let rest: Vec<usize> = (0..lin.rows.len()).filter(is_of_none).collect();
        let rest = sums(&Rows { some: rest, is_one: Vec::new(), clusters: Vec::new() });
        let all = blocks.iter().fold(rest, |sum, block| (sum.0 + &block.0, sum.1 + &block.1));
        Self { effects, directions: directions.ncols(), all, blocks, members }
    }

    /// What may be significant at `alpha` without a block.
    pub(super) fn passing(
        &self,
        beside: &Beside,
        single: &[&str],
        (block, alpha): (usize, f64),
    ) -> Passing {
        let left = self.left(beside, block);
        let mut seen = self.seen(beside, &left, block);
        seen.retain(|seen| !seen.one.only_instead);
        let class = classes(&seen, &left);
        let trials = trials(&seen, &class, single);
        let adjusted = adjusted(&seen, &trials);
        let passes = (0..seen.len()).filter(|&i| adjusted[i] <= alpha);
        let passing: Vec<One> = passes
            .map(|i| One { effect: seen[i].one.effect, class: class[i], trials: trials[i] })
            .collect();
        if !passing.is_empty() {
            return Passing::These(passing);
        }
        if pair_may_pass(beside, &left, (&seen, &class), alpha) {
            Passing::Any
        } else {
            Passing::Nothing
        }
    }

    /// Sets of effects without a block, of which those of `named` are held against the others; `None`
    /// where one of them is not seen.
    pub(super) fn sets(&self, beside: &Beside, block: usize, named: &[usize]) -> Option<Sets> {
        let left = self.left(beside, block);
        let mut seen = self.seen(beside, &left, block);
        seen.retain(|seen| !seen.is_local);
        let member = |(seen, class): (&Seen<'_>, usize)| Member {
            class,
            is_named: named.contains(&seen.one.effect),
            explained: seen.data.norm_squared(),
        };
        let members: Vec<Member> = seen.iter().zip(classes(&seen, &left)).map(member).collect();
        let tried = tried(&members);
        if tried.iter().filter(|&&i| members[i].is_named).count() < named.len() {
            return None;
        }
        let last = left.ncols() - 1;
        let columns: Vec<usize> = tried.iter().flat_map(|&i| seen[i].columns.clone()).collect();
        let mut next = 0;
        let ranges = tried.iter().map(|&i| {
            let start = next;
            next += seen[i].columns.len();
            start..next
        });
        let n = columns.len();
        Some(Sets {
            searched: tried.iter().map(|&i| seen[i].one.searched).collect(),
            coordinates: tried.iter().map(|&i| seen[i].one.coordinates).collect(),
            named: named.len(),
            columns: ranges.collect(),
            products: DMatrix::from_fn(n, n, |i, j| left[(columns[i], columns[j])]),
            onto: DVector::from_fn(n, |i, _| left[(columns[i], last)]),
            square: beside.squares[0],
            rows: beside.rows,
        })
    }

    /// The p-value of each that is seen without a block, adjusted for how much is looked at.
    #[cfg(test)]
    pub(super) fn adjusted(&self, beside: &Beside, single: &[&str], block: usize) -> Vec<f64> {
        let left = self.left(beside, block);
        let seen = self.seen(beside, &left, block);
        adjusted(&seen, &trials(&seen, &classes(&seen, &left), single))
    }

    /// Of products of the effects' columns and of the data, last, what the system leaves without a
    /// block.
    fn left(&self, beside: &Beside, block: usize) -> DMatrix<f64> {
        let products = &self.all.0 - &self.blocks[block].0;
        let (k, m) = (self.directions, products.ncols() - self.directions);
        let held = beside.held(&products.view((0, k), (k, m)).into_owned(), false);
        products.view((k, k), (m, m)) - held.transpose() * &held
    }

    fn seen(&self, beside: &Beside, left: &DMatrix<f64>, block: usize) -> Vec<Seen<'_>> {
        let last = left.ncols() - 1;
        let rest = |all: f64, block: f64| {
            if all - block > ROUND_OFF * all { all - block } else { f64::INFINITY }
        };
        let whole = self.all.1.zip_map(&self.blocks[block].1, rest);
        let of = |one: &'_ Open| {
            let (start, n) = (one.columns.start, one.columns.len());
            let own = left.view((start, start), (n, n)).into_owned();
            let new =
                Independent::of(&own, |column| one.min_kept * one.min_kept * whole[start + column]);
            if new.kept.is_empty() {
                return None;
            }
            let onto = left.view((start, last), (n, 1)).column(0).into_owned();
            let data = new.along_one(&onto);
            let test = f_test_of(
                data.norm_squared(),
                data.len(),
                beside.squares[0],
                beside.rows,
                beside.directions[0],
            )?;
            let is_local = one.has_subject && self.is_local(one, &new.kept, block);
            let columns = new.kept.iter().map(|column| start + column).collect();
            Some((data, columns, new.factor, is_local, test))
        };
        let seen = |one| {
            let (data, columns, factor, is_local, test) = of(one)?;
            Some(Seen { one, data, columns, factor, is_local, test })
        };
        self.effects.iter().filter_map(seen).collect()
    }

    /// Whether the kept columns move one cluster alone that is not of the block.
    fn is_local(&self, one: &Open, kept: &[usize], block: usize) -> bool {
        let mut home = None;
        for &column in kept {
            let Some(moved) = &one.moved[column] else { return false };
            for &cluster in moved.iter().filter(|c| !self.members[block].contains(c)) {
                if home.is_some_and(|home| home != cluster) {
                    return false;
                }
                home = Some(cluster);
            }
        }
        home.is_some()
    }
}

/// Cosines between the orthonormal directions of two effects.
fn cosines(a: &Seen<'_>, b: &Seen<'_>, left: &DMatrix<f64>) -> DMatrix<f64> {
    let mut cosines = DMatrix::from_fn(a.columns.len(), b.columns.len(), |i, j| {
        left[(a.columns[i], b.columns[j])]
    });
    a.factor.solve_lower_triangular_mut(&mut cosines);
    let mut cosines = cosines.transpose();
    b.factor.solve_lower_triangular_mut(&mut cosines);
    cosines
}

/// Class of each: those whose directions beside the system are the same share one.
fn classes(seen: &[Seen<'_>], left: &DMatrix<f64>) -> Vec<usize> {
    let mut classes: Vec<usize> = Vec::with_capacity(seen.len());
    for (i, one) in seen.iter().enumerate() {
        let is_twin = |j: &usize| {
            let other = &seen[*j];
            !other.is_local
                && !one.is_local
                && other.columns.len() == one.columns.len()
                && same_directions(&cosines(other, one, left))
        };
        let twin = (0..i).find(is_twin);
        classes.push(twin.map_or(i, |j| classes[j]));
    }
    classes
}

/// By how much the p-value of each counts more for how much else is looked at.
fn trials(seen: &[Seen<'_>], class: &[usize], single: &[&str]) -> Vec<f64> {
    let mut families: Vec<(&str, usize)> = Vec::new();
    let mut tests = single.len();
    for (i, one) in seen.iter().enumerate() {
        let id = one.one.id.as_str();
        if single.contains(&id) {
            continue;
        }
        if !one.is_local {
            tests += usize::from(class[i] == i);
        } else if let Some((_, n)) = families.iter_mut().find(|(known, _)| *known == id) {
            *n += 1;
        } else {
            tests += 1;
            families.push((id, 1));
        }
    }
    let of_family = |seen: &Seen<'_>| {
        let size = families.iter().find(|(id, _)| seen.is_local && *id == seen.one.id);
        count(tests) * size.map_or(1.0, |(_, n)| count(*n))
    };
    seen.iter().map(of_family).collect()
}

fn adjusted(seen: &[Seen<'_>], trials: &[f64]) -> Vec<f64> {
    let adjusted = |(seen, trials): (&Seen<'_>, &f64)| {
        ((seen.test.p_value * seen.one.searched).min(1.0) * trials).min(1.0)
    };
    seen.iter().zip(trials).map(adjusted).collect()
}

/// Whether two effects may be significant together, as the F test has it.
fn pair_may_pass(
    beside: &Beside,
    left: &DMatrix<f64>,
    (seen, class): (&[Seen<'_>], &[usize]),
    alpha: f64,
) -> bool {
    let first = |i: &usize| class.iter().position(|c| *c == class[*i]) == Some(*i);
    let representatives: Vec<&Seen<'_>> = (0..seen.len())
        .filter(|&i| !seen[i].is_local)
        .filter(first)
        .map(|i| &seen[i])
        .take(MAX_CLASSES)
        .collect();
    let n = representatives.len();
    let pairs = count(n * n.saturating_sub(1) / 2);
    let level = alpha * QUARTER / CATALOGUE_SHARE / pairs;
    let square = beside.squares[0];
    let passes = |a: &Seen<'_>, b: &Seen<'_>| {
        // Of the second beside the first.
        let cosines = cosines(a, b, left);
        let own = DMatrix::identity(b.data.len(), b.data.len()) - &cosines * cosines.transpose();
        let new = Independent::of(&own, |_| NEW_BESIDE * NEW_BESIDE);
        if new.kept.len() < b.data.len() {
            return false;
        }
        let more = new.along_one(&(&b.data - &cosines * &a.data)).norm_squared();
        let explained = a.data.norm_squared() + more;
        if square - explained <= LEFT_BY_ANY * square {
            return false;
        }
        let directions = a.data.len() + b.data.len();
        let test = f_test_of(explained, directions, square, beside.rows, beside.directions[0]);
        test.is_some_and(|test| test.p_value * a.one.searched * b.one.searched <= level)
    };
    (0..n).any(|i| (i + 1..n).any(|j| passes(representatives[i], representatives[j])))
}
