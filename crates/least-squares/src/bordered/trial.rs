//! Second pass: the blocks' steps for a step of the shared point, and what they gain.
#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use super::block::{Scratch, robust_cost};
use super::program::Program;
use super::simd::{Task, mul_add};
use super::{BorderedPoint, BorderedProblem};
use crate::RobustRows;

/// What the steps of a chunk of blocks come to.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gain {
    /// `Σ ρ` at the new point.
    pub(super) twice_cost: f64,
    /// `Σ (r_new − r − J δ)²`: curvature, and for short steps rounding.
    pub(super) unexplained: f64,
    /// `δᵀ D δ` with the diagonal `D` of `Jᵀ J`, blocks only.
    pub(super) scaled_step: f64,
}

impl Gain {
    pub(super) fn add(&mut self, other: Self) {
        self.twice_cost += other.twice_cost;
        self.unexplained += other.unexplained;
        self.scaled_step += other.scaled_step;
    }
}

/// Moves the blocks from `point` to `moved`, given the step of each column.
pub(super) struct Try<'a, P> {
    pub(super) problem: &'a P,
    pub(super) program: &'a Program,
    pub(super) robust: &'a [RobustRows],
    pub(super) point: &'a BorderedPoint,
    pub(super) damping: f64,
    /// Step by column; nought for the first, which is the residual's, and for padding.
    pub(super) step: &'a [f64],
    /// Shared point after the step.
    pub(super) shared: &'a [f64],
    pub(super) blocks: std::ops::Range<usize>,
    /// New points of these blocks.
    pub(super) moved: &'a mut [f64],
    pub(super) scratch: &'a mut Scratch,
}

impl<P: BorderedProblem> Task for Try<'_, P> {
    type Output = Gain;

    #[inline(always)]
    fn run<const FUSED: bool>(self) -> Gain {
        match self.program.block_dim {
            1 => self.step::<FUSED>(1),
            2 => self.step::<FUSED>(2),
            3 => self.step::<FUSED>(3),
            6 => self.step::<FUSED>(6),
            9 => self.step::<FUSED>(9),
            12 => self.step::<FUSED>(12),
            b => self.step::<FUSED>(b),
        }
    }
}

impl<P: BorderedProblem> Try<'_, P> {
    #[inline(always)]
    fn step<const FUSED: bool>(self, b: usize) -> Gain {
        let Self { problem, program, robust, point, damping, step, shared, blocks, moved, scratch } =
            self;
        let block_len = point.block_len(program.block_count);
        let mut gain = Gain::default();
        for (i, block) in blocks.enumerate() {
            let compiled = &program.patterns[problem.pattern_of(block)];
            let old = &point.blocks[block * block_len..][..block_len];
            let new = &mut moved[i * block_len..][..block_len];
            scratch.linearise(problem, compiled, robust, block, &point.shared, old);
            let mut predicted = std::mem::take(&mut scratch.predicted);
            // Rows after the shared step alone; their gradient is g_b + W x.
            scratch.form::<FUSED>(b, compiled, |row, residuals, by_shared| {
                let mut sum = residuals[row];
                for entry in &compiled.entries[compiled.rows[row].entries.clone()] {
                    sum = mul_add::<FUSED>(by_shared[entry.value], step[entry.column], sum);
                }
                predicted[row] = sum;
                sum
            });
            if program.is_held(block) {
                scratch.step[..b].fill(0.0);
                new.copy_from_slice(old);
            } else {
                scratch.factor::<FUSED>(b, damping);
                let Scratch { v, inverse_diagonal, step, diagonal, .. } = scratch;
                super::cholesky::solve::<FUSED>(b, v, inverse_diagonal, &mut step[..b]);
                for (s, d) in step[..b].iter_mut().zip(diagonal) {
                    *s = -*s;
                    gain.scaled_step = mul_add::<FUSED>(*d * *s, *s, gain.scaled_step);
                }
                problem.retract_block(block, old, &step[..b], new);
            }
            for (row, sum) in compiled.rows.iter().zip(&mut predicted) {
                let columns = &compiled.block_columns[row.by_block.clone()];
                for (&c, &v) in columns.iter().zip(&scratch.by_block[row.by_block.clone()]) {
                    *sum = mul_add::<FUSED>(v, scratch.step[c], *sum);
                }
            }
            scratch.compare(problem, robust, block, shared, new, &predicted, &mut gain);
            scratch.predicted = predicted;
        }
        gain
    }
}

impl Scratch {
    /// Adds the cost of a block at its new point, and what `predicted` misses of its rows.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the innermost loop's state")]
    fn compare<P: BorderedProblem>(
        &mut self,
        problem: &P,
        robust: &[RobustRows],
        block: usize,
        shared: &[f64],
        point: &[f64],
        predicted: &[f64],
        gain: &mut Gain,
    ) {
        let rows = problem.patterns()[problem.pattern_of(block)].residual_count();
        let residuals = &mut self.residuals[..rows];
        problem.residuals(block, shared, point, residuals);
        if robust.is_empty() {
            gain.twice_cost += residuals.iter().map(|r| r * r).sum::<f64>();
            let missed = residuals.iter().zip(predicted).map(|(r, p)| (r - p).powi(2));
            gain.unexplained += missed.sum::<f64>();
        } else {
            // Against the weights before the step, with which the prediction was made.
            let missed = residuals.iter().zip(predicted).zip(&self.weights);
            gain.unexplained += missed.map(|((r, p), w)| (w * r - p).powi(2)).sum::<f64>();
            gain.twice_cost += robust_cost(robust, residuals, &mut self.weights[..rows]);
        }
    }
}
