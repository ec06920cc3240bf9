//! Deviations that stand in other rows than they were read in: what the repeats say.

use super::approach::POSITIONS;
use super::directions::variation;
use super::places::Places;
use crate::case::{Change, Edit, Table};
use crate::count::count;
use crate::suspect::Hypothesis;

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
    pub(super) table: &'t Table,
    pub(super) read: &'static str,
    pub(super) values: &'t [f64],
    pub(super) targets: &'t [f64],
    pub(super) places: &'t Places,
    /// Standard uncertainty of a reading, in the unit of the column.
    pub(super) sigma: Option<f64>,
}

impl Rows<'_> {
    /// The order of the rows with which the repeats agree as noise does, and as they stand far less.
    pub(super) fn in_another_order(&self) -> Option<Hypothesis> {
        let before = self.disagreement(self.values)?;
        let tried = self.shifted().chain(self.turned());
        let all: Vec<_> =
            tried.filter_map(|order| Some((self.disagreement(&order.1)?, order))).collect();
        let least = all.iter().map(|(left, _)| *left).min_by(f64::total_cmp)?;
        // An axis that goes there and back reads the same from its other end on: the smallest shift is the one.
        let (after, (what, values)) = all.into_iter().find(|(left, _)| *left <= ALIKE * least)?;
        let gain = before / after;
        let is_noise = self.sigma.is_none_or(|sigma| after <= NOISE * sigma);
        let is_evident = count(self.values.len()) * gain.ln() >= EVIDENCE;
        if gain < TIDIER || !is_noise || !is_evident {
            return None;
        }
        let description = format!(
            "`{}` of {POSITIONS} {what} against the other columns: with that put right the repeats at one target \
             and both ways to it disagree {gain:.0} times less",
            self.read
        );
        let change = Change::Replace { column: self.read.to_owned(), values };
        let edits = vec![Edit { file: POSITIONS, change }];
        let found =
            Hypothesis::of("input:row-shift", (POSITIONS, &[self.read]), description, edits);
        Some(found.certain())
    }

    /// By how much the repeats at one target scatter from either side, or the sides lie apart by another amount from
    /// target to target: a shift by some rows of cycles that are all alike leaves the repeats as they are.
    fn disagreement(&self, values: &[f64]) -> Option<f64> {
        let scatter = self.places.scatter(values, |_| true)?;
        let sides = self.places.both_sides(values);
        let apart = variation(sides.iter().map(|[rising, falling]| rising.value - falling.value));
        Some(if sides.len() < FEWEST_OF_A_PASS { scatter } else { scatter.max(apart) })
    }

    /// All rows further down or up by any number, those that leave the table at its other end; the smallest first.
    fn shifted(&self) -> impl Iterator<Item = (String, Vec<f64>)> + '_ {
        let n = self.values.len();
        let shifted = move |(by, is_down): (usize, bool)| {
            let mut values = self.values.to_vec();
            let way = if is_down { "down" } else { "up" };
            if is_down {
                values.rotate_left(by);
            } else {
                values.rotate_right(by);
            }
            (format!("is shifted {by} rows {way}, cyclically,"), values)
        };
        (1..=FARTHEST.min(n / 2)).flat_map(|by| [(by, true), (by, false)]).map(shifted)
    }

    /// One pass over the targets the other way round.
    fn turned(&self) -> impl Iterator<Item = (String, Vec<f64>)> + '_ {
        self.passes().map(move |pass| {
            let mut values = self.values.to_vec();
            values[pass.clone()].reverse();
            let [first, last] = [pass.start, pass.end - 1].map(|row| self.table.line(row));
            (format!("stands in reverse order from line {first} to line {last}"), values)
        })
    }

    /// Rows over which the targets only rise, or only fall.
    fn passes(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
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
        passes.into_iter().filter(|pass| pass.len() >= FEWEST_OF_A_PASS)
    }
}
