//! Which of many measurements serve a question best: optimal design on matrices alone.
//!
//! A measurement is a few whitened rows X of the linearised model; its information is `XᵀX`, and
//! information adds up. What a design leaves of some columns beside others is a Schur complement of
//! the sum: its quadratic form is the non-centrality with which an effect stands beside its rival
//! (T-optimality), its inverse the variance of a parameter (c-optimality), its determinant what is
//! known of all parameters together (D-optimality). Chosen forward, one at a time, then exchanged
//! while that helps (Fedorov 1972).

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::kinds::Offer;

/// Information added to every column of unit length: a direction that no row shows is left free
/// without a division by zero.
const RIDGE: f64 = 1e-9;
/// Weight of what goes beyond the goal of one question while others are short of theirs.
const BEYOND: f64 = 0.01;
/// A non-centrality that is nothing.
const NOTHING: f64 = 1e-3;
/// Rounds of exchange; the second seldom finds anything.
const ROUNDS: usize = 2;
/// Gain below which an exchange is round-off.
const GAIN: f64 = 1e-9;
/// A non-centrality that no further measurement is worth.
pub(super) const HOPELESS: f64 = 1.0;
/// Fewest recorded runs of a plan.
const FEWEST_RUNS: usize = 4;

/// What a design is asked for, in columns of the linearised model.
#[derive(Clone, Debug)]
pub(super) enum Goal {
    /// The columns `of`, at `amplitude`, stand beside others with this non-centrality; `from` is
    /// the rival among them that an effect is to be told from as well.
    Seen {
        of: Vec<usize>,
        amplitude: DVector<f64>,
        beside: Vec<usize>,
        needed: f64,
        from: Option<String>,
    },
    /// The variance of one column beside others falls to a share of the present one.
    Known { of: usize, beside: Vec<usize>, needed: f64 },
    /// The determinant of the information on all of these grows.
    Determined { columns: Vec<usize> },
}

/// The information of what is measured, and of each measurement that could be.
pub(super) struct Design {
    measured: DMatrix<f64>,
    offered: Vec<DMatrix<f64>>,
    /// Of all of these together.
    all: DMatrix<f64>,
    /// Length of every column over all rows, by which they are scaled.
    lengths: Vec<f64>,
    /// Columns of the base, the first ones: always estimated beside what is to be seen.
    n_base: usize,
}

/// Information, and what it leaves of all other columns beside those of the base.
struct Summed<'i> {
    all: &'i DMatrix<f64>,
    left: DMatrix<f64>,
}

/// How many measurements may be chosen; none is always enough.
#[derive(Clone, Copy, Debug)]
pub(super) struct Number {
    pub(super) least: usize,
    pub(super) most: usize,
}

impl Number {
    pub(super) fn up_to(most: usize) -> Self {
        Self { least: 0, most }
    }

    /// Runs that are recorded are groups each, and how far groups lie apart shows in four, not in two.
    pub(super) fn of(offer: &Offer, most: usize) -> Self {
        Self { least: if offer.is_record { FEWEST_RUNS } else { 0 }, most }
    }
}

impl Design {
    pub(super) fn of(measured: &DMatrix<f64>, offered: &[DMatrix<f64>], n_base: usize) -> Self {
        let square = |block: &DMatrix<f64>, column: usize| block.column(column).norm_squared();
        let length = |column: usize| {
            let all: f64 = offered.iter().map(|block| square(block, column)).sum();
            (all + square(measured, column)).sqrt().max(f64::MIN_POSITIVE)
        };
        let lengths: Vec<f64> = (0..measured.ncols()).map(length).collect();
        let information = |block: &DMatrix<f64>| {
            let mut scaled = block.clone();
            for (mut column, length) in scaled.column_iter_mut().zip(&lengths) {
                column.unscale_mut(*length);
            }
            scaled.tr_mul(&scaled)
        };
        let offered: Vec<DMatrix<f64>> = offered.iter().map(information).collect();
        let measured = information(measured);
        let all = offered.iter().fold(measured.clone(), |sum, one| sum + one);
        Self { measured, offered, all, lengths, n_base }
    }

    pub(super) fn n_offered(&self) -> usize {
        self.offered.len()
    }

    /// Information of what is measured and of the chosen.
    pub(super) fn with(&self, chosen: &[usize]) -> DMatrix<f64> {
        chosen.iter().fold(self.measured.clone(), |sum, &one| sum + &self.offered[one])
    }

    /// Information of what is measured and of everything on offer.
    pub(super) fn with_all(&self) -> &DMatrix<f64> {
        &self.all
    }

    /// Non-centrality of a goal, the variance in units of the columns, or the determinant's
    /// logarithm.
    pub(super) fn value(&self, goal: &Goal, information: &DMatrix<f64>) -> f64 {
        self.value_of(goal, &self.summed(information))
    }

    fn summed<'i>(&self, information: &'i DMatrix<f64>) -> Summed<'i> {
        let base: Vec<usize> = (0..self.n_base).collect();
        let others: Vec<usize> = (self.n_base..information.ncols()).collect();
        Summed { all: information, left: left(information, &others, &base) }
    }

    fn value_of(&self, goal: &Goal, summed: &Summed<'_>) -> f64 {
        let information = summed.all;
        match goal {
            Goal::Seen { of, amplitude, beside, .. } => {
                let lengths = DVector::from_iterator(of.len(), of.iter().map(|&c| self.lengths[c]));
                let amplitude = amplitude.component_mul(&lengths);
                let inner = |columns: &[usize]| -> Vec<usize> {
                    columns.iter().filter_map(|c| c.checked_sub(self.n_base)).collect()
                };
                let left = left(&summed.left, &inner(of), &inner(beside));
                amplitude.dot(&(left * &amplitude)).max(0.0)
            }
            Goal::Known { of, beside, .. } => {
                let left = left(information, &[*of], beside)[(0, 0)];
                (left.max(RIDGE) * self.lengths[*of].powi(2)).recip()
            }
            Goal::Determined { columns } => {
                let all = information.select_rows(columns).select_columns(columns);
                let all = all + DMatrix::identity(columns.len(), columns.len()) * RIDGE;
                all.cholesky().map_or(f64::NEG_INFINITY, |c| {
                    2.0 * c.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>()
                })
            }
        }
    }

    /// How well the goals are served together; what is reached counts little more.
    fn score(&self, goals: &[Goal], present: &[f64], information: &DMatrix<f64>) -> f64 {
        let summed = self.summed(information);
        let of = |(goal, present): (&Goal, &f64)| {
            let value = self.value_of(goal, &summed);
            match goal {
                Goal::Seen { needed, .. } => short((value + NOTHING).ln() - needed.ln()),
                Goal::Known { needed, .. } => short((present * needed).ln() - value.ln()),
                Goal::Determined { .. } => value,
            }
        };
        goals.iter().zip(present).map(of).sum()
    }

    /// Whether a goal is met.
    pub(super) fn is_met(&self, goal: &Goal, information: &DMatrix<f64>) -> bool {
        self.is_met_by(goal, &self.summed(information))
    }

    fn is_met_by(&self, goal: &Goal, summed: &Summed<'_>) -> bool {
        let value = self.value_of(goal, summed);
        match goal {
            Goal::Seen { needed, .. } => value >= *needed,
            Goal::Known { needed, .. } => value <= needed * self.value(goal, &self.measured),
            Goal::Determined { .. } => false,
        }
    }

    /// Whether all goals are met with the chosen, and those of effects without any one of them too:
    /// what rests on a single measurement passes for a mistake of that one, and cannot be judged
    /// with it left out.
    pub(super) fn are_safe(&self, goals: &[Goal], chosen: &[usize]) -> bool {
        let all = self.with(chosen);
        let summed = self.summed(&all);
        if !goals.iter().all(|goal| self.is_met_by(goal, &summed)) {
            return false;
        }
        let seen: Vec<&Goal> =
            goals.iter().filter(|goal| matches!(goal, Goal::Seen { .. })).collect();
        chosen.par_iter().all(|&one| {
            let without = &all - &self.offered[one];
            let summed = self.summed(&without);
            seen.iter().all(|goal| self.is_met_by(goal, &summed))
        })
    }

    /// Chosen one after another and exchanged, at most `most`; as they were where an exchange, which looks
    /// at all of them together, costs the goals that hold without any single one.
    pub(super) fn chosen(&self, goals: &[Goal], number: Number) -> Vec<usize> {
        let forward = self.forward(goals, number);
        let exchanged = self.exchanged(goals, forward.clone());
        let is_lost = self.are_safe(goals, &forward) && !self.are_safe(goals, &exchanged);
        if is_lost { forward } else { exchanged }
    }

    /// The measurements chosen one after another, until the goals are safe, or there are as many as may be; some are no
    /// fewer than the least.
    pub(super) fn forward(&self, goals: &[Goal], Number { least, most }: Number) -> Vec<usize> {
        let present = self.present(goals);
        let mut chosen: Vec<usize> = Vec::new();
        let mut sum = self.measured.clone();
        let is_few = |chosen: &[usize]| !chosen.is_empty() && chosen.len() < least;
        let is_left = |chosen: &[usize]| chosen.len() < most.min(self.n_offered());
        while is_left(&chosen) && (is_few(&chosen) || !self.are_safe(goals, &chosen)) {
            let Some((best, _)) = self.best(goals, &present, &sum, &chosen) else { break };
            sum += &self.offered[best];
            chosen.push(best);
        }
        chosen
    }

    /// Exchanges chosen ones for others while that serves the goals better.
    pub(super) fn exchanged(&self, goals: &[Goal], mut chosen: Vec<usize>) -> Vec<usize> {
        let present = self.present(goals);
        let mut sum = self.with(&chosen);
        let mut score = self.score(goals, &present, &sum);
        for _ in 0..ROUNDS {
            let before = score;
            for place in 0..chosen.len() {
                let without = &sum - &self.offered[chosen[place]];
                let found = self.best(goals, &present, &without, &chosen);
                if let Some((best, better)) = found.filter(|(_, better)| *better > score + GAIN) {
                    sum = without + &self.offered[best];
                    (chosen[place], score) = (best, better);
                }
            }
            if score <= before + GAIN {
                break;
            }
        }
        chosen
    }

    fn present(&self, goals: &[Goal]) -> Vec<f64> {
        goals.iter().map(|goal| self.value(goal, &self.measured)).collect()
    }

    /// The offered one, not chosen yet, with which the goals are served best; the first of equals.
    fn best(
        &self,
        goals: &[Goal],
        present: &[f64],
        sum: &DMatrix<f64>,
        chosen: &[usize],
    ) -> Option<(usize, f64)> {
        let free: Vec<usize> = (0..self.n_offered()).filter(|i| !chosen.contains(i)).collect();
        let scores: Vec<f64> = (free.par_iter())
            .map(|&i| self.score(goals, present, &(sum + &self.offered[i])))
            .collect();
        let (mut best, mut highest) = (None, f64::NEG_INFINITY);
        for (&i, &score) in free.iter().zip(&scores) {
            if best.is_none() || score > highest {
                (best, highest) = (Some(i), score);
            }
        }
        best.map(|best| (best, highest))
    }
}

/// What is short of a goal counts in full, what is beyond it little.
fn short(logarithm: f64) -> f64 {
    if logarithm > 0.0 { BEYOND * logarithm } else { logarithm }
}

/// Information on the columns `of` once those `beside` are estimated too.
fn left(information: &DMatrix<f64>, of: &[usize], beside: &[usize]) -> DMatrix<f64> {
    let own = information.select_rows(of).select_columns(of);
    if beside.is_empty() {
        return own;
    }
    let ridge = DMatrix::identity(beside.len(), beside.len()) * RIDGE;
    let theirs = information.select_rows(beside).select_columns(beside) + ridge;
    let mixed = information.select_rows(beside).select_columns(of);
    match theirs.cholesky() {
        Some(theirs) => own - mixed.tr_mul(&theirs.solve(&mixed)),
        None => DMatrix::zeros(of.len(), of.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::{Design, Goal, Number};
    use nalgebra::{DMatrix, DVector};

    /// Rows (1, x) of a straight line.
    fn line(at: &[f64]) -> Vec<DMatrix<f64>> {
        at.iter().map(|x| DMatrix::from_row_slice(1, 2, &[1.0, *x])).collect()
    }

    #[test]
    fn a_slope_is_known_best_from_the_ends() {
        let offered = line(&[-1.0, -0.5, 0.0, 0.5, 1.0, -0.9, 0.9]);
        let measured = DMatrix::from_row_slice(2, 2, &[1.0, -0.1, 1.0, 0.1]);
        let design = Design::of(&measured, &offered, 0);
        let goals = [Goal::Known { of: 1, beside: vec![0], needed: 1e-3 }];
        let chosen = design.forward(&goals, Number::up_to(2));
        assert_eq!([chosen[0].min(chosen[1]), chosen[0].max(chosen[1])], [0, 4]);
        // Σ(x − x̄)² of −1, −0.1, 0.1, 1.
        let variance = design.value(&goals[0], &design.with(&chosen));
        assert!((variance - 1.0 / 2.02).abs() < 1e-6, "{variance}");
    }

    #[test]
    fn exchange_mends_a_bad_start() {
        let offered = line(&[0.0, 0.1, -1.0, 1.0]);
        let measured = DMatrix::from_row_slice(1, 2, &[1.0, 0.0]);
        let design = Design::of(&measured, &offered, 0);
        let goals = [Goal::Determined { columns: vec![0, 1] }];
        let mut chosen = design.exchanged(&goals, vec![0, 1]);
        chosen.sort_unstable();
        assert_eq!(chosen, [2, 3]);
    }

    /// Two columns that are the same where it was measured: what tells them apart is chosen, and
    /// its non-centrality is the square of the part at right angles.
    #[test]
    fn rivals_are_told_apart_where_they_differ() {
        let measured = DMatrix::from_row_slice(3, 2, &[1.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
        let offered: Vec<_> = [[1.0, 1.0], [1.0, 0.0], [1.0, 0.9]]
            .map(|row| DMatrix::from_row_slice(1, 2, &row))
            .into();
        let design = Design::of(&measured, &offered, 0);
        let amplitude = DVector::from_element(1, 2.0);
        let beside = vec![1];
        let goal = Goal::Seen { of: vec![0], amplitude, beside, needed: 2.9, from: None };
        let goals = [goal];
        assert!(design.value(&goals[0], &design.with(&[])) < 1e-6);
        assert!(!design.is_met(&goals[0], &design.with(&[0])));
        let chosen = [1];
        // One alone is not safe; the others show less than is needed.
        assert!(design.is_met(&goals[0], &design.with(&chosen)));
        assert!(!design.are_safe(&goals, &chosen));
        assert_eq!(design.forward(&goals, Number::up_to(3))[0], 1);
        // (1, 1, 1, 1)·2 less its part along (1, 1, 1, 0): 4.
        let value = design.value(&goals[0], &design.with(&chosen));
        assert!((value - 4.0).abs() < 1e-6, "{value}");
    }
}
