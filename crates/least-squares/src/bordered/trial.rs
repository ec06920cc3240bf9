//! Second pass: the blocks' steps for a step of the shared point, and what they gain.
#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use std::ops::Range;

use super::BorderedProblem;
use super::block::{Place, Scratch, robust_cost};
use super::lanes::Lanes;
use super::program::{Compiled, Group, Program};
use super::simd::Task;
use super::triangle::{self, row_start};

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

/// Room for the steps of four blocks.
pub(super) struct Steps {
    /// Rows as the step makes them, as far as their derivatives say.
    predicted: Vec<Lanes>,
    step: Vec<Lanes>,
    /// Diagonal of `V`.
    diagonal: Vec<Lanes>,
    residuals: Vec<f64>,
    root_weights: Vec<f64>,
    of_block: Vec<f64>,
}

impl Steps {
    pub(super) fn new(program: &Program) -> Self {
        let rows = program.limits.rows;
        Self {
            predicted: vec![Lanes::ZERO; rows],
            step: vec![Lanes::ZERO; program.block_dim],
            diagonal: vec![Lanes::ZERO; program.block_dim],
            residuals: vec![0.0; rows],
            root_weights: vec![1.0; rows],
            of_block: vec![0.0; program.block_dim],
        }
    }
}

/// Moves the blocks in a range of the program's order, given the step of each column.
pub(super) struct Try<'a, P> {
    pub(super) place: Place<'a, P>,
    pub(super) damping: f64,
    /// Step by column; nought for the first, which is the residual's.
    pub(super) step: &'a [f64],
    /// Shared point after the step.
    pub(super) shared: &'a [f64],
    pub(super) blocks: Range<usize>,
    /// New points of these blocks.
    pub(super) moved: &'a mut [f64],
    pub(super) scratch: &'a mut Scratch,
    pub(super) steps: &'a mut Steps,
}

impl<P: BorderedProblem> Task for Try<'_, P> {
    type Output = Gain;

    #[inline(always)]
    fn run<S: pulp::Simd, const FUSED: bool>(self, _: S) -> Gain {
        match self.place.program.block_dim {
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
    fn step<const FUSED: bool>(mut self, b: usize) -> Gain {
        let program = self.place.program;
        let mut gain = Gain::default();
        let mut at = self.blocks.start;
        while at < self.blocks.end {
            let group = program.group(at, self.blocks.end);
            at += group.count;
            let compiled = program.compiled(group.blocks[0]);
            self.scratch.linearise(self.place, compiled, &group);
            self.steps.follow_shared::<FUSED>(compiled, &self.scratch.values, self.step);
            if group.is_held {
                self.steps.step.fill(Lanes::ZERO);
            } else {
                self.scratch.form_own::<FUSED>(b, compiled, &group);
                let own = &mut self.scratch.own;
                for (c, diagonal) in self.steps.diagonal[..b].iter_mut().enumerate() {
                    *diagonal = own[row_start(c) + c];
                }
                triangle::factor::<FUSED>(b, own, self.damping);
                gain.scaled_step += self.steps.solve::<FUSED>(own);
            }
            self.compare::<FUSED>(compiled, &group, &mut gain);
        }
        gain
    }

    /// Adds the cost of a group's blocks at their new points, and what the prediction misses.
    #[inline(always)]
    fn compare<const FUSED: bool>(&mut self, compiled: &Compiled, group: &Group, gain: &mut Gain) {
        let Self { place, shared, blocks, moved, scratch, steps, .. } = self;
        let of_blocks = &scratch.values[compiled.limits.rows..];
        steps.follow_blocks::<FUSED>(compiled, of_blocks);
        let block_len = place.point.block_len(place.program.block_count);
        for (lane, &block) in group.blocks[..group.count].iter().enumerate() {
            for (out, step) in steps.of_block.iter_mut().zip(&steps.step) {
                *out = step.0[lane];
            }
            let new = &mut moved[(block - blocks.start) * block_len..][..block_len];
            let old = place.block(block);
            if group.is_held {
                new.copy_from_slice(old);
            } else {
                place.problem.retract_block(block, old, &steps.of_block, new);
            }
            let residuals = &mut steps.residuals[..compiled.limits.rows];
            place.problem.residuals(block, shared, new, residuals);
            let rows = residuals.iter().zip(&steps.predicted);
            if place.robust.is_empty() {
                gain.twice_cost += residuals.iter().map(|r| r * r).sum::<f64>();
                gain.unexplained += rows.map(|(r, p)| (r - p.0[lane]).powi(2)).sum::<f64>();
            } else {
                // Against the weights before the step, with which the prediction was made.
                let missed = rows.zip(scratch.weights(lane));
                gain.unexplained +=
                    missed.map(|((r, p), w)| (w * r - p.0[lane]).powi(2)).sum::<f64>();
                let weights = &mut steps.root_weights[..residuals.len()];
                gain.twice_cost += robust_cost(place.robust, residuals, weights);
            }
        }
    }
}

impl Steps {
    /// Rows after the shared step alone, and their gradient `g_b + W x`.
    #[inline(always)]
    fn follow_shared<const FUSED: bool>(
        &mut self,
        compiled: &Compiled,
        values: &[Lanes],
        step: &[f64],
    ) {
        let (residuals, rest) = values.split_at(compiled.limits.rows);
        let (by_block, by_shared) = rest.split_at(compiled.limits.by_block);
        self.step.fill(Lanes::ZERO);
        for ((row, residual), predicted) in
            compiled.rows.iter().zip(residuals).zip(&mut self.predicted)
        {
            let mut sum = *residual;
            for entry in &compiled.entries[row.entries.clone()] {
                let step = Lanes::splat(step[entry.column]);
                sum = by_shared[entry.value].mul_add::<FUSED>(step, sum);
            }
            *predicted = sum;
            let columns = &compiled.block_columns[row.by_block.clone()];
            for (&column, value) in columns.iter().zip(&by_block[row.by_block.clone()]) {
                self.step[column] = value.mul_add::<FUSED>(sum, self.step[column]);
            }
        }
    }

    /// Turns the gradient into the step; its squared length in lengths of the columns.
    #[inline(always)]
    fn solve<const FUSED: bool>(&mut self, factor: &[Lanes]) -> f64 {
        triangle::forward::<FUSED>(factor, &mut self.step);
        triangle::backward::<FUSED>(factor, &mut self.step);
        let mut squares = Lanes::ZERO;
        for (step, diagonal) in self.step.iter_mut().zip(&self.diagonal) {
            *step = step.times(Lanes::splat(-1.0));
            squares = step.times(*diagonal).mul_add::<FUSED>(*step, squares);
        }
        squares.sum()
    }

    /// Adds what the blocks' own steps do to the rows.
    #[inline(always)]
    fn follow_blocks<const FUSED: bool>(&mut self, compiled: &Compiled, by_block: &[Lanes]) {
        for (row, predicted) in compiled.rows.iter().zip(&mut self.predicted) {
            let columns = &compiled.block_columns[row.by_block.clone()];
            for (&column, value) in columns.iter().zip(&by_block[row.by_block.clone()]) {
                *predicted = value.mul_add::<FUSED>(self.step[column], *predicted);
            }
        }
    }
}
