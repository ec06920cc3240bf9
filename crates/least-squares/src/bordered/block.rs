//! One block at one point: its rows, its normal equations, its step.
#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use super::program::{Compiled, Program};
use super::simd::mul_add;
use super::{BlockRows, BorderedProblem, cholesky};
use crate::RobustRows;

/// Room for one block's numbers, reused for all blocks of a chunk.
pub(super) struct Scratch {
    pub(super) residuals: Vec<f64>,
    pub(super) by_block: Vec<f64>,
    pub(super) by_shared: Vec<f64>,
    /// Root weights of the robust losses.
    pub(super) weights: Vec<f64>,
    /// Lower triangle of `V = J_bᵀ J_b`, then its factor, by rows.
    pub(super) v: Vec<f64>,
    pub(super) inverse_diagonal: Vec<f64>,
    pub(super) step: Vec<f64>,
    /// Diagonal of `V`.
    pub(super) diagonal: Vec<f64>,
    /// What the rows become by a step, as far as their derivatives say.
    pub(super) predicted: Vec<f64>,
}

impl Scratch {
    pub(super) fn new(program: &Program) -> Self {
        let (limits, b) = (program.limits, program.block_dim);
        Self {
            residuals: vec![0.0; limits.rows],
            by_block: vec![0.0; limits.by_block],
            by_shared: vec![0.0; limits.by_shared],
            weights: vec![1.0; limits.rows],
            v: vec![0.0; b * b],
            inverse_diagonal: vec![0.0; b],
            step: vec![0.0; b],
            diagonal: vec![0.0; b],
            predicted: vec![0.0; limits.rows],
        }
    }

    /// Evaluates a block and weighs its rows; `Σ ρ`, not finite where a residual is not.
    #[inline(always)]
    pub(super) fn linearise<P: BorderedProblem>(
        &mut self,
        problem: &P,
        compiled: &Compiled,
        robust: &[RobustRows],
        block: usize,
        shared: &[f64],
        point: &[f64],
    ) -> f64 {
        let limits = compiled.limits;
        let residuals = &mut self.residuals[..limits.rows];
        let by_block = &mut self.by_block[..limits.by_block];
        let by_shared = &mut self.by_shared[..limits.by_shared];
        let rows = BlockRows { residuals, by_block, by_shared };
        problem.linearise(block, shared, point, rows);
        if robust.is_empty() {
            self.residuals[..limits.rows].iter().map(|r| r * r).sum()
        } else {
            self.weigh(compiled, robust)
        }
    }

    /// Multiplies the rows by the roots of their robust weights.
    fn weigh(&mut self, compiled: &Compiled, robust: &[RobustRows]) -> f64 {
        let rows = compiled.limits.rows;
        let residuals = &self.residuals[..rows];
        let twice_cost = robust_cost(robust, residuals, &mut self.weights[..rows]);
        for (i, row) in compiled.rows.iter().enumerate() {
            let weight = self.weights[i];
            self.residuals[i] *= weight;
            self.by_block[row.by_block.clone()].iter_mut().for_each(|v| *v *= weight);
            for entry in &compiled.entries[row.entries.clone()] {
                self.by_shared[entry.value] *= weight;
            }
        }
        twice_cost
    }

    /// `V`, its diagonal and the gradient `J_bᵀ t` for rows `t`, which is left in `step`.
    #[inline(always)]
    pub(super) fn form<const FUSED: bool>(
        &mut self,
        b: usize,
        compiled: &Compiled,
        mut rows: impl FnMut(usize, &[f64], &[f64]) -> f64,
    ) {
        self.v[..b * b].fill(0.0);
        self.step[..b].fill(0.0);
        for (i, row) in compiled.rows.iter().enumerate() {
            let t = rows(i, &self.residuals, &self.by_shared);
            let columns = &compiled.block_columns[row.by_block.clone()];
            let values = &self.by_block[row.by_block.clone()];
            for (p, (&cp, &vp)) in columns.iter().zip(values).enumerate() {
                self.step[cp] = mul_add::<FUSED>(vp, t, self.step[cp]);
                for (&cq, &vq) in columns[..=p].iter().zip(values) {
                    let at = cp.max(cq) * b + cp.min(cq);
                    self.v[at] = mul_add::<FUSED>(vp, vq, self.v[at]);
                }
            }
        }
        for c in 0..b {
            self.diagonal[c] = self.v[c * b + c];
        }
    }

    /// Factors `V`; the least share of a diagonal entry that is left of it.
    #[inline(always)]
    pub(super) fn factor<const FUSED: bool>(&mut self, b: usize, damping: f64) -> f64 {
        cholesky::factor::<FUSED>(b, &mut self.v[..b * b], &mut self.inverse_diagonal[..b], damping)
    }
}

/// `Σ ρ` over all rows, without the cancellation between large squares and what a loss takes off
/// them; writes the roots of the rows' weights.
pub(super) fn robust_cost(
    robust: &[RobustRows],
    residuals: &[f64],
    root_weights: &mut [f64],
) -> f64 {
    root_weights.fill(1.0);
    let is_plain = |row: usize| !robust.iter().any(|robust| robust.rows.contains(&row));
    let plain = residuals.iter().enumerate().filter(|(row, _)| is_plain(*row));
    let mut twice_cost = plain.map(|(_, r)| r * r).sum();
    for RobustRows { rows, block_rows, loss } in robust {
        let end = rows.end.min(residuals.len());
        let mut first = rows.start;
        while first < end {
            let last = first.saturating_add(*block_rows).min(end);
            let s: f64 = residuals[first..last].iter().map(|r| r * r).sum();
            let (rho, weight) = loss.evaluate(s);
            twice_cost += rho;
            root_weights[first..last].fill(weight.sqrt());
            first = last;
        }
    }
    twice_cost
}
