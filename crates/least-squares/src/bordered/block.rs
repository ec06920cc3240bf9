//! Blocks at one point: one by one as the problem gives them, and four side by side.
#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use super::lanes::{LANES, Lanes};
use super::program::{Compiled, Group, Limits, Products, Program, Sum};
use super::triangle::row_start;
use super::{BlockRows, BorderedPoint, BorderedProblem};
use crate::RobustRows;

/// Where blocks are evaluated.
pub(super) struct Place<'a, P> {
    pub(super) problem: &'a P,
    pub(super) program: &'a Program,
    pub(super) robust: &'a [RobustRows],
    pub(super) point: &'a BorderedPoint,
}

impl<P> Clone for Place<'_, P> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<P> Copy for Place<'_, P> {}

impl<P: BorderedProblem> Place<'_, P> {
    /// Numbers of one block's point.
    #[inline(always)]
    pub(super) fn block(&self, block: usize) -> &[f64] {
        let block_len = self.point.block_len(self.program.block_count);
        &self.point.blocks[block * block_len..][..block_len]
    }
}

/// Residuals and derivatives of one block, numbered through.
#[derive(Debug)]
pub(super) struct Rows {
    numbers: Vec<f64>,
    /// Root weights of the robust losses.
    pub(super) weights: Vec<f64>,
}

impl Rows {
    pub(super) fn new(limits: Limits) -> Self {
        Self { numbers: vec![0.0; limits.numbers()], weights: vec![1.0; limits.rows] }
    }

    /// Evaluates a block as the problem gives it.
    #[inline(always)]
    pub(super) fn evaluate<P: BorderedProblem>(
        &mut self,
        place: Place<'_, P>,
        compiled: &Compiled,
        block: usize,
    ) {
        let rows = self.split(compiled.limits);
        place.problem.linearise(block, &place.point.shared, place.block(block), rows);
    }

    /// Evaluates a block and weighs its rows; `Σ ρ`, not finite where a residual is not.
    #[inline(always)]
    pub(super) fn linearise<P: BorderedProblem>(
        &mut self,
        place: Place<'_, P>,
        compiled: &Compiled,
        block: usize,
    ) -> f64 {
        self.evaluate(place, compiled, block);
        if place.robust.is_empty() {
            self.numbers[..compiled.limits.rows].iter().map(|r| r * r).sum()
        } else {
            self.weigh(compiled, place.robust)
        }
    }

    /// Residuals of a block of so many rows, as evaluated last.
    pub(super) fn residuals(&self, rows: usize) -> &[f64] {
        &self.numbers[..rows]
    }

    #[inline(always)]
    pub(super) fn split(&mut self, limits: Limits) -> BlockRows<'_> {
        let (residuals, rest) = self.numbers.split_at_mut(limits.rows);
        let (by_block, rest) = rest.split_at_mut(limits.by_block);
        BlockRows { residuals, by_block, by_shared: &mut rest[..limits.by_shared] }
    }

    /// Multiplies the rows by the roots of their robust weights.
    fn weigh(&mut self, compiled: &Compiled, robust: &[RobustRows]) -> f64 {
        let limits = compiled.limits;
        let mut weights = std::mem::take(&mut self.weights);
        let BlockRows { residuals, by_block, by_shared } = self.split(limits);
        let twice_cost = robust_cost(robust, residuals, &mut weights[..limits.rows]);
        for ((i, row), weight) in compiled.rows.iter().enumerate().zip(&weights) {
            residuals[i] *= weight;
            for value in &mut by_block[row.by_block.clone()] {
                *value *= weight;
            }
            for entry in &compiled.entries[row.entries.clone()] {
                by_shared[entry.value] *= weight;
            }
        }
        self.weights = weights;
        twice_cost
    }
}

/// Room for four blocks' numbers, reused for all blocks of a chunk.
#[derive(Debug)]
pub(super) struct Scratch {
    rows: [Rows; LANES],
    /// Numbers of [`Rows`], four blocks side by side.
    pub(super) values: Vec<Lanes>,
    /// Packed lower triangle of `V = J_bᵀ J_b`, then its factor.
    pub(super) own: Vec<Lanes>,
}

impl Scratch {
    pub(super) fn new(program: &Program) -> Self {
        let limits = program.limits;
        Self {
            rows: std::array::from_fn(|_| Rows::new(limits)),
            values: vec![Lanes::ZERO; limits.numbers()],
            own: vec![Lanes::ZERO; row_start(program.block_dim)],
        }
    }

    /// Numbers of one lane's block.
    #[inline(always)]
    pub(super) fn rows_of(&mut self, lane: usize) -> &mut Rows {
        &mut self.rows[lane]
    }

    /// Root weights of one lane's rows.
    pub(super) fn weights(&self, lane: usize) -> &[f64] {
        &self.rows[lane].weights
    }

    /// Evaluates a group's blocks side by side; `Σ ρ`. Lanes without a block are nought.
    #[inline(always)]
    pub(super) fn linearise<P: BorderedProblem>(
        &mut self,
        place: Place<'_, P>,
        compiled: &Compiled,
        group: &Group,
    ) -> f64 {
        let mut twice_cost = 0.0;
        for lane in 0..LANES {
            let rows = &mut self.rows[lane];
            if lane < group.count {
                twice_cost += rows.linearise(place, compiled, group.blocks[lane]);
            } else {
                rows.numbers.fill(0.0);
            }
        }
        let numbers = compiled.limits.numbers();
        let [a, b, c, d] = &self.rows;
        let sources = a.numbers[..numbers].iter().zip(&b.numbers).zip(&c.numbers).zip(&d.numbers);
        for (out, (((a, b), c), d)) in self.values.iter_mut().zip(sources) {
            *out = Lanes([*a, *b, *c, *d]);
        }
        twice_cost
    }

    /// `V`, with a diagonal of ones in lanes without a block.
    #[inline(always)]
    pub(super) fn form_own<const FUSED: bool>(
        &mut self,
        b: usize,
        compiled: &Compiled,
        group: &Group,
    ) {
        self.own.fill(Lanes::ZERO);
        add_products::<FUSED>(&compiled.own, &self.values, &mut self.own);
        for c in 0..b {
            for lane in group.count..LANES {
                self.own[row_start(c) + c].0[lane] = 1.0;
            }
        }
    }
}

/// Adds up products of a block's numbers.
#[inline(always)]
pub(super) fn add_products<const FUSED: bool>(
    products: &Products,
    values: &[Lanes],
    sums: &mut [Lanes],
) {
    for &[a, b, to] in &products.single {
        let sum = &mut sums[to as usize];
        *sum = values[a as usize].mul_add::<FUSED>(values[b as usize], *sum);
    }
    let mut pairs = &products.pairs[..];
    for &Sum { to, count } in &products.sums {
        let (own, rest) = pairs.split_at(count as usize);
        let mut sum = sums[to as usize];
        for &[a, b] in own {
            sum = values[a as usize].mul_add::<FUSED>(values[b as usize], sum);
        }
        (sums[to as usize], pairs) = (sum, rest);
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
