//! Deviations that stand in other rows than they were read in: what the repeats say.

use std::ops::Range;

use super::directions::variation;
use super::places::Places;
use crate::case::{Change, Edit, Table};
use crate::count::count;
use crate::suspect::{Hypothesis, median};

/// Times less that repeats scatter where their rows are put right.
const TIDIER: f64 = 5.0;
/// Times the declared noise that they may then still scatter.
const NOISE: f64 = 1.6;
/// Logarithm of the odds that so much less scatter must have: a hundred orders are tried, over thousands of cases.
const EVIDENCE: f64 = 30.0;
/// Times the least disagreement that is as good.
const ALIKE: f64 = 1.5;
/// Rows of a shift at most.
const FARTHEST: usize = 500;
/// Readings of a pass that can stand the other way round.
const FEWEST_OF_A_PASS: usize = 4;

/// Deviations, their places and the way to each, as their table has them.
pub(super) struct Rows<'t> {
    pub(super) file: &'static str,
    pub(super) table: &'t Table,
    pub(super) read: &'static str,
    pub(super) values: &'t [f64],
    pub(super) targets: &'t [f64],
    pub(super) places: &'t Places,
    /// Standard uncertainty of a reading, in the unit of the column.
    pub(super) sigma: Option<f64>,
}

/// In which order the rows may stand.
enum Order {
    /// All so many rows too far down, those that leave the table at its other end.
    Down(usize),
    Up(usize),
    /// One pass over the targets the other way round.
    Reversed(Range<usize>),
}

impl Order {
    /// The values in the rows that they were read in.
    fn put_right(&self, values: &[f64]) -> Vec<f64> {
        let mut values = values.to_vec();
        match self {
            Self::Down(rows) => values.rotate_left(*rows),
            Self::Up(rows) => values.rotate_right(*rows),
            Self::Reversed(pass) => values[pass.clone()].reverse(),
        }
        values
    }

    fn said(&self, table: &Table) -> String {
        match self {
            Self::Down(rows) => format!("is shifted {rows} rows down, cyclically,"),
            Self::Up(rows) => format!("is shifted {rows} rows up, cyclically,"),
            Self::Reversed(Range { start, end }) => {
                let [first, last] = [*start, end - 1].map(|row| table.line(row));
                format!("stands in reverse order from line {first} to line {last}")
            }
        }
    }
}

impl Rows<'_> {
    /// The order of the rows with which the repeats agree as noise does, and as they stand far less.
    pub(super) fn in_another_order(&self) -> Option<Hypothesis> {
        // As they stand most targets disagree: what does at a few of them, from one side, is the axis.
        let before = self.disagreement(self.values, typical)?;
        let shifts = (1..=FARTHEST.min(self.values.len() / 2))
            .flat_map(|rows| [Order::Down(rows), Order::Up(rows)]);
        let tried = shifts.chain(self.passes().into_iter().map(Order::Reversed));
        let left = |order: &Order| self.disagreement(&order.put_right(self.values), rms);
        let all: Vec<_> = tried.filter_map(|order| Some((left(&order)?, order))).collect();
        let least = all.iter().map(|(left, _)| *left).min_by(f64::total_cmp)?;
        // An axis that goes there and back reads the same from its other end on: the smallest shift is the one.
        let (after, order) = all.into_iter().find(|(left, _)| *left <= ALIKE * least)?;
        let gain = before / after;
        let is_noise = self.sigma.is_none_or(|sigma| after <= NOISE * sigma);
        let is_evident = count(self.values.len()) * gain.ln() >= EVIDENCE;
        if gain < TIDIER || !is_noise || !is_evident {
            return None;
        }
        let description = format!(
            "`{}` of {} {} against the other columns: with that put right the repeats at one target and \
             both ways to it disagree {gain:.0} times less",
            self.read,
            self.file,
            order.said(self.table)
        );
        let values = order.put_right(self.values);
        let change = Change::Replace { column: self.read.to_owned(), values };
        let edits = vec![Edit { file: self.file, change }];
        let found =
            Hypothesis::of("input:row-shift", (self.file, &[self.read]), description, edits);
        Some(found.certain())
    }

    /// By how much the repeats at one target scatter from either side, or the sides lie apart by another amount from
    /// target to target: a shift by some rows of cycles that are all alike leaves the repeats as they are.
    fn disagreement(&self, values: &[f64], spread: fn(Vec<f64>) -> f64) -> Option<f64> {
        let scatter = self.places.scatter(values, |_| true)?;
        let sides = self.places.both_sides(values);
        if sides.len() < FEWEST_OF_A_PASS {
            return Some(scatter);
        }
        let apart = sides.iter().map(|[rising, falling]| rising.value - falling.value).collect();
        Some(scatter.max(spread(apart)))
    }

    /// Rows over which the targets only rise, or only fall.
    fn passes(&self) -> Vec<Range<usize>> {
        let goes_on = |a: usize| self.targets[a + 1] - self.targets[a];
        let mut start = 0;
        let mut passes = Vec::new();
        for row in 1..self.targets.len() {
            // Of the target at which the axis turns round each way has its own reading.
            let has_turned = row >= start + 2 && goes_on(row - 2) * goes_on(row - 1) <= 0.0;
            if has_turned || row == start + 1 && goes_on(start) == 0.0 {
                passes.push(start..row);
                start = row;
            }
        }
        passes.push(start..self.targets.len());
        passes.retain(|pass| pass.len() >= FEWEST_OF_A_PASS);
        passes
    }
}

/// Root mean square of values about their mean.
fn rms(values: Vec<f64>) -> f64 {
    variation(values.into_iter())
}

/// Standard deviation of most of some values: the median of what they are off by, times what it is less of a normal law.
fn typical(values: Vec<f64>) -> f64 {
    const OF_A_NORMAL_LAW: f64 = 1.4826;
    let middle = median(values.clone());
    OF_A_NORMAL_LAW * median(values.into_iter().map(|value| (value - middle).abs()).collect())
}
