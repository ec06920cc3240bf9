//! Sets of candidates compared by how well they describe the data, from products of their columns.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::algebra::independent::Independent;
use crate::count::count;
use crate::levels::{LEFT_BY_ANY, MIN_KEPT, WORTH_MENTIONING};

/// Most candidates of which all pairs are tried, the strongest alone first.
const MOST_CANDIDATES: usize = 40;
/// Most of the named that are replaced at once, of three and more.
const MOST_REPLACED: usize = 2;
/// Share of its norm that each column of a set must keep beside the others: two that nearly cancel would
/// have to be ten times as large as what they describe.
const APART: f64 = 0.1;

/// A candidate that may be in a set.
pub(crate) struct Member {
    pub(crate) class: usize,
    pub(crate) is_named: bool,
    /// Square of the data that it explains alone.
    pub(crate) explained: f64,
}

/// Which candidates are tried, the named and then the strongest first: one of each class, and all that
/// are named.
pub(crate) fn tried(members: &[Member]) -> Vec<usize> {
    let of_named = |class| members.iter().any(|m| m.is_named && m.class == class);
    let is_tried =
        |&i: &usize| members[i].is_named || members[i].class == i && !of_named(members[i].class);
    let mut order: Vec<usize> = (0..members.len()).filter(is_tried).collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (&members[a], &members[b]);
        b.is_named.cmp(&a.is_named).then(b.explained.total_cmp(&a.explained))
    });
    order.truncate(MOST_CANDIDATES);
    order
}

/// Candidates beside a system, of which sets are compared.
pub(crate) struct Sets {
    /// How many like each were looked at to find it.
    pub(crate) searched: Vec<f64>,
    /// What was fitted in looking for each.
    pub(crate) coordinates: Vec<usize>,
    /// How many of the first were named.
    pub(crate) named: usize,
    /// Which columns are each candidate's, and products of what the system leaves of these with each
    /// other and with the data.
    pub(crate) columns: Vec<Range<usize>>,
    pub(crate) products: DMatrix<f64>,
    pub(crate) onto: DVector<f64>,
    /// Square of what the system leaves of the data, and of how many rows.
    pub(crate) square: f64,
    pub(crate) rows: usize,
}

/// How well a set of candidates describes the data.
#[derive(Clone, Copy)]
pub(crate) struct Description {
    /// Amplitudes, and what was fitted in looking for it.
    numbers: usize,
    /// Share of the squared residual that it leaves.
    left: f64,
    /// What its size costs.
    pub(crate) penalty: f64,
    /// Bayesian information criterion relative to none of them; lower is better.
    criterion: f64,
}

impl Sets {
    /// Sets that describe the data clearly better than what was named, the best first; in place of one
    /// name alone those with half its numbers at most.
    pub(crate) fn better(&self) -> Vec<(Vec<usize>, Description)> {
        let own = self.of_named();
        let mut better: Vec<(Vec<usize>, Description)> = (self.all().into_iter())
            .map(|set| {
                let description = self.describe(&set);
                (set, description)
            })
            .filter(|(_, one)| one.criterion < own.criterion - WORTH_MENTIONING)
            .filter(|(_, one)| self.named > 1 || 2 * one.numbers <= own.numbers)
            .filter(|(set, one)| one.left > LEFT_BY_ANY && self.are_apart(set))
            .collect();
        better.sort_by(|a, b| a.1.criterion.total_cmp(&b.1.criterion));
        better
    }

    /// What was named.
    pub(crate) fn of_named(&self) -> Description {
        self.describe(&(0..self.named).collect::<Vec<_>>())
    }

    /// Every set that is tried.
    fn all(&self) -> Vec<Vec<usize>> {
        let n = self.columns.len();
        let mut sets: Vec<Vec<usize>> = (0..n).map(|i| vec![i]).collect();
        sets.extend((0..n).flat_map(|i| (i + 1..n).map(move |j| vec![i, j])));
        // Sets of one and two are there.
        for out in 1..=self.named.saturating_sub(1).min(MOST_REPLACED) {
            for rest in some_of(self.named, self.named - out) {
                for new in (0..=out).flat_map(|many| some_of(n - self.named, many)) {
                    let new = new.into_iter().map(|i| self.named + i);
                    let set: Vec<usize> = rest.iter().copied().chain(new).collect();
                    if set.len() > 2 {
                        sets.push(set);
                    }
                }
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
        let searched: f64 = set.iter().map(|&i| self.searched[i].ln()).sum();
        let products = self.products_of(set);
        let new = Independent::of(&products, |c| MIN_KEPT * MIN_KEPT * products[(c, c)]);
        let columns = set.iter().flat_map(|&i| self.columns[i].clone());
        let onto = DVector::from_iterator(products.ncols(), columns.map(|c| self.onto[c]));
        let left = (self.square - new.along_one(&onto).norm_squared()).max(0.0) / self.square;
        let (amplitudes, of_size) = (new.kept.len(), ways(self.columns.len(), set.len()));
        let numbers = amplitudes + set.iter().map(|&i| self.coordinates[i]).sum::<usize>();
        let penalty = count(amplitudes) * count(self.rows).ln() + 2.0 * (searched + of_size.ln());
        let criterion = count(self.rows) * left.max(f64::MIN_POSITIVE).ln() + penalty;
        Description { numbers, left, penalty, criterion }
    }

    /// Products of the columns of a set.
    fn products_of(&self, set: &[usize]) -> DMatrix<f64> {
        let columns: Vec<usize> = set.iter().flat_map(|&i| self.columns[i].clone()).collect();
        let n = columns.len();
        DMatrix::from_fn(n, n, |i, j| self.products[(columns[i], columns[j])])
    }
}

/// Every choice of so many of the first `of` numbers.
pub(crate) fn some_of(of: usize, many: usize) -> Vec<Vec<usize>> {
    if many == 0 {
        return vec![Vec::new()];
    }
    let with_last = |last: usize| {
        some_of(last, many - 1).into_iter().map(move |mut some| {
            some.push(last);
            some
        })
    };
    (many - 1..of).flat_map(with_last).collect()
}

/// Number of sets of a size.
fn ways(of: usize, size: usize) -> f64 {
    (0..size).map(|k| count(of.saturating_sub(k).max(1)) / count(k + 1)).product()
}
