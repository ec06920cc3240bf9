//! The dense rest: normal equations of the shared point once the blocks are eliminated.

use nalgebra::{DMatrix, DVector};

use super::BorderedProblem;
use super::eliminate::Sums;
use super::program::Program;
use crate::qr::dot;

/// Room for the normal equations of the shared point and for its rows.
pub(super) struct Reduced {
    /// Residuals that depend on the shared point alone, and their derivatives.
    pub(super) residuals: Vec<f64>,
    jacobian: Vec<f64>,
    /// Normal equations' lower triangle by rows, then its factor.
    normal: Vec<f64>,
    gradient: Vec<f64>,
    /// Diagonal of `J_sᵀ J_s`.
    pub(super) diagonal: Vec<f64>,
    /// `Σ ρ` over all rows.
    pub(super) twice_cost: f64,
    /// Twice what the blocks alone promise.
    blocks_promised: f64,
    /// Step by column, nought for the first.
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
            normal: vec![0.0; n * n],
            gradient: vec![0.0; n],
            diagonal: vec![0.0; n],
            twice_cost: 0.0,
            blocks_promised: 0.0,
            step: vec![0.0; 1 + n],
            tangent: vec![0.0; program.shared_dim],
            promised: 0.0,
            least_pivot: 1.0,
        }
    }

    /// Collects the normal equations from the sums of all blocks and the rows that depend on the
    /// shared point alone.
    pub(super) fn collect<P: BorderedProblem>(
        &mut self,
        problem: &P,
        program: &Program,
        shared: &[f64],
        sums: &Sums,
    ) {
        let n = program.free.len();
        self.normal.fill(0.0);
        self.diagonal.fill(0.0);
        self.gradient.fill(0.0);
        for (slot, &[row, column]) in sums.slots.iter().zip(&program.slots) {
            self.add(n, row, column, slot.sum());
        }
        for (diagonal, i) in self.diagonal.iter_mut().zip(0..n) {
            *diagonal = self.normal[i * n + i];
        }
        self.twice_cost = sums.twice_cost;
        if !self.residuals.is_empty() {
            problem.linearise_shared(shared, &mut self.residuals, &mut self.jacobian);
            self.add_shared_rows(program);
        }
        for i in 0..n {
            self.gradient[i] += sums.reduction.entry(0, 1 + i);
            for j in 0..=i {
                self.normal[i * n + j] += sums.reduction.entry(1 + j, 1 + i);
            }
        }
        self.blocks_promised = -sums.reduction.entry(0, 0);
    }

    /// Adds to the entry of two columns, the first of them not after the second.
    fn add(&mut self, n: usize, row: usize, column: usize, value: f64) {
        match row.checked_sub(1) {
            Some(j) => self.normal[(column - 1) * n + j] += value,
            None => self.gradient[column - 1] += value,
        }
    }

    fn add_shared_rows(&mut self, program: &Program) {
        let (n, dim) = (program.free.len(), program.shared_dim);
        for (row, r) in self.jacobian.chunks_exact(dim.max(1)).zip(&self.residuals) {
            self.twice_cost += r * r;
            for (i, &a) in program.free.iter().enumerate() {
                if row[a] == 0.0 {
                    continue;
                }
                for (j, &b) in program.free[..=i].iter().enumerate() {
                    self.normal[i * n + j] += row[a] * row[b];
                }
                self.gradient[i] += r * row[a];
                self.diagonal[i] += row[a] * row[a];
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
    pub(super) fn solve(&mut self, program: &Program, damping: f64) {
        let n = program.free.len();
        self.least_pivot = 1.0;
        for i in 0..n {
            self.step[1 + i] = -self.gradient[i];
            self.normal[i * n + i] += damping * self.diagonal[i];
            self.eliminate(n, i, self.diagonal[i] * (1.0 + damping));
        }
        self.promised = self.blocks_promised + dot(&self.step[1..], &self.step[1..]);
        for i in (0..n).rev() {
            let row = &self.normal[i * n..][..=i];
            let known = self.step[1 + i] * row[i];
            for (x, f) in self.step[1..=i].iter_mut().zip(row) {
                *x -= f * known;
            }
            self.step[1 + i] = known;
        }
        for (i, &direction) in program.free.iter().enumerate() {
            self.tangent[direction] = self.step[1 + i];
        }
    }

    /// The factor as an upper triangle, once the equations are solved.
    pub(super) fn triangle(&self, n: usize) -> DMatrix<f64> {
        DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
            std::cmp::Ordering::Less => self.normal[j * n + i],
            std::cmp::Ordering::Equal => self.normal[i * n + i].recip(),
            std::cmp::Ordering::Greater => 0.0,
        })
    }

    /// Lengths of the shared columns; 1 for a column of zeros.
    pub(super) fn lengths(&self) -> DVector<f64> {
        let length = |s: &f64| if *s > 0.0 { s.sqrt() } else { 1.0 };
        DVector::from_iterator(self.diagonal.len(), self.diagonal.iter().map(length))
    }

    /// Turns row `i` into that of the factor, with the reciprocal of its diagonal entry, and the
    /// right-hand side likewise. A row that the others determine is cut off by a nought.
    fn eliminate(&mut self, n: usize, i: usize, whole: f64) {
        let (above, row) = self.normal.split_at_mut(i * n);
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
