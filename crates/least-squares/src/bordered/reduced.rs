//! The dense rest: normal equations of the shared point once the blocks are eliminated.

use super::BorderedProblem;
use super::eliminate::Sums;
use super::program::Program;
use crate::qr::dot;

/// Room for the normal equations of the shared point and for its rows.
pub(super) struct Reduced {
    /// Residuals that depend on the shared point alone, and their derivatives.
    pub(super) residuals: Vec<f64>,
    jacobian: Vec<f64>,
    /// Lower factor, by rows.
    factor: Vec<f64>,
    /// Step by column, nought for the first and for padding.
    pub(super) step: Vec<f64>,
    /// Step of all shared directions.
    pub(super) tangent: Vec<f64>,
    /// `gᵀ H⁻¹ g`: twice what a full step promises.
    pub(super) promised: f64,
    /// Least share of a diagonal entry that the elimination leaves.
    pub(super) least_pivot: f64,
}

impl Reduced {
    pub(super) fn new(program: &Program, shared_rows: usize) -> Self {
        let n = program.free.len();
        Self {
            residuals: vec![0.0; shared_rows],
            jacobian: vec![0.0; shared_rows * program.shared_dim],
            factor: vec![0.0; n * n],
            step: vec![0.0; program.width],
            tangent: vec![0.0; program.shared_dim],
            promised: 0.0,
            least_pivot: 1.0,
        }
    }

    /// Adds the rows that depend on the shared point alone.
    pub(super) fn add_shared_rows<P: BorderedProblem>(
        &mut self,
        problem: &P,
        program: &Program,
        shared: &[f64],
        sums: &mut Sums,
    ) {
        if self.residuals.is_empty() {
            return;
        }
        problem.linearise_shared(shared, &mut self.residuals, &mut self.jacobian);
        let rows = self.jacobian.chunks_exact(program.shared_dim.max(1));
        for (row, r) in rows.zip(&self.residuals) {
            sums.twice_cost += r * r;
            for (i, &a) in program.free.iter().enumerate() {
                if row[a] == 0.0 {
                    continue;
                }
                let line = &mut sums.reduced[(1 + i) * program.width..];
                for (j, &b) in program.free.iter().enumerate().skip(i) {
                    line[1 + j] += row[a] * row[b];
                }
                sums.reduced[1 + i] += r * row[a];
                sums.diagonal[1 + i] += row[a] * row[a];
            }
        }
    }

    /// Rows that depend on the shared point alone, after a step: their squares, and what the
    /// derivatives do not explain.
    pub(super) fn try_shared_rows<P: BorderedProblem>(
        &self,
        problem: &P,
        shared: &[f64],
        residuals: &mut [f64],
        jacobian: &mut [f64],
    ) -> (f64, f64) {
        if residuals.is_empty() {
            return (0.0, 0.0);
        }
        problem.linearise_shared(shared, residuals, jacobian);
        let (mut squares, mut unexplained) = (0.0, 0.0);
        let rows = self.jacobian.chunks_exact(self.tangent.len().max(1));
        for ((new, old), row) in residuals.iter().zip(&self.residuals).zip(rows) {
            let predicted = old + row.iter().zip(&self.tangent).map(|(d, s)| d * s).sum::<f64>();
            squares += new * new;
            unexplained += (new - predicted).powi(2);
        }
        (squares, unexplained)
    }

    /// Factors the equations and solves them for the step of the shared point.
    pub(super) fn solve(&mut self, program: &Program, sums: &Sums, damping: f64) {
        let (n, width) = (program.free.len(), program.width);
        self.least_pivot = 1.0;
        for i in 0..n {
            for j in 0..i {
                self.factor[i * n + j] = sums.reduced[(1 + j) * width + 1 + i];
            }
            self.step[1 + i] = -sums.reduced[1 + i];
            let diagonal = sums.diagonal[1 + i];
            self.factor[i * n + i] =
                damping.mul_add(diagonal, sums.reduced[(1 + i) * width + 1 + i]);
            self.eliminate(n, i, diagonal * (1.0 + damping));
        }
        self.promised = sums.promised + dot(&self.step[1..=n], &self.step[1..=n]);
        for i in (0..n).rev() {
            let row = &self.factor[i * n..][..=i];
            let known = self.step[1 + i] * row[i];
            self.step[1 + i] = known;
            for (x, f) in self.step[1..=i].iter_mut().zip(row) {
                *x -= f * known;
            }
        }
        for (i, &direction) in program.free.iter().enumerate() {
            self.tangent[direction] = self.step[1 + i];
        }
    }

    /// Turns row `i` into that of the factor, with the reciprocal of its diagonal entry, and the
    /// right-hand side likewise. A row that the others determine is cut off by a nought.
    fn eliminate(&mut self, n: usize, i: usize, whole: f64) {
        let (above, row) = self.factor.split_at_mut(i * n);
        let row = &mut row[..n];
        for (j, other) in above.chunks_exact(n).enumerate() {
            row[j] = (row[j] - dot(&row[..j], &other[..j])) * other[j];
        }
        let left = row[i] - dot(&row[..i], &row[..i]);
        let share = left / whole;
        let is_good = share > f64::EPSILON;
        self.least_pivot = self.least_pivot.min(if is_good { share } else { 0.0 });
        row[i] = if is_good { 1.0 / left.sqrt() } else { 0.0 };
        self.step[1 + i] = (self.step[1 + i] - dot(&row[..i], &self.step[1..=i])) * row[i];
    }
}
