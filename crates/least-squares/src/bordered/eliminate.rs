//! First pass: eliminates the blocks of a chunk and adds up what is left for the shared point.
#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use std::ops::Range;

use super::BorderedProblem;
use super::block::{Place, Scratch, add_products};
use super::lanes::{LANES, Lanes};
use super::panels::{Panels, downdate};
use super::program::{PANEL, Program};
use super::simd::Task;
use super::triangle;

/// What a chunk of blocks adds to the reduced normal equations, or all do, and scratch.
pub(super) struct Sums {
    /// Products of shared columns, by slot of the program.
    pub(super) slots: Vec<Lanes>,
    /// `−Yᵀ Y` with `Y = L⁻¹ J_bᵀ [r J_s]`.
    pub(super) reduction: Panels,
    /// `Σ ρ`.
    pub(super) twice_cost: f64,
    /// Least share of a block's diagonal entry that the elimination leaves.
    pub(super) least_pivot: f64,
    /// `Y` of four blocks side by side, by panel and block direction.
    columns: Vec<[Lanes; PANEL]>,
    /// `Y` by panel, block direction and block.
    y: Vec<[f64; PANEL]>,
}

impl Sums {
    pub(super) fn new(program: &Program) -> Self {
        let panels = program.first.len();
        Self {
            slots: vec![Lanes::ZERO; program.slots.len()],
            reduction: Panels::new(panels),
            twice_cost: 0.0,
            least_pivot: 1.0,
            columns: vec![[Lanes::ZERO; PANEL]; program.starts[panels]],
            y: vec![[0.0; PANEL]; panels * program.block_dim * LANES],
        }
    }

    pub(super) fn clear(&mut self) {
        self.slots.fill(Lanes::ZERO);
        self.reduction.clear();
        (self.twice_cost, self.least_pivot) = (0.0, 1.0);
    }

    /// Adds the sums of another chunk.
    pub(super) fn add(&mut self, other: &Self) {
        for (sum, other) in self.slots.iter_mut().zip(&other.slots) {
            for (a, b) in sum.0.iter_mut().zip(other.0) {
                *a += b;
            }
        }
        self.reduction.add(&other.reduction);
        self.twice_cost += other.twice_cost;
        self.least_pivot = self.least_pivot.min(other.least_pivot);
    }
}

/// Eliminates the blocks in a range of the program's order.
pub(super) struct Eliminate<'a, P> {
    pub(super) place: Place<'a, P>,
    pub(super) blocks: Range<usize>,
    pub(super) damping: f64,
    pub(super) scratch: &'a mut Scratch,
    pub(super) sums: &'a mut Sums,
}

impl<P: BorderedProblem> Task for Eliminate<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run<S: pulp::Simd, const FUSED: bool>(self, _: S) {
        // The compiler unrolls the loops over a block's directions where it knows their number.
        match self.place.program.block_dim {
            3 => self.eliminate::<FUSED>(3),
            6 => self.eliminate::<FUSED>(6),
            9 => self.eliminate::<FUSED>(9),
            12 => self.eliminate::<FUSED>(12),
            b => self.eliminate::<FUSED>(b),
        }
    }
}

impl<P: BorderedProblem> Eliminate<'_, P> {
    #[inline(always)]
    fn eliminate<const FUSED: bool>(self, b: usize) {
        let Self { place, blocks, damping, scratch, sums } = self;
        let program = place.program;
        sums.clear();
        let mut at = blocks.start;
        while at < blocks.end {
            let group = program.group(at, blocks.end);
            at += group.count;
            let compiled = program.compiled(group.blocks[0]);
            sums.twice_cost += scratch.linearise(place, compiled, &group);
            add_products::<FUSED>(&compiled.shared, &scratch.values, &mut sums.slots);
            if group.is_held {
                continue;
            }
            scratch.form_own::<FUSED>(b, compiled, &group);
            sums.columns.fill([Lanes::ZERO; PANEL]);
            let columns = sums.columns.as_flattened_mut();
            add_products::<FUSED>(&compiled.coupling, &scratch.values, columns);
            let least = triangle::factor::<FUSED>(b, &mut scratch.own, damping);
            sums.least_pivot = sums.least_pivot.min(least);
            sums.solve_columns::<FUSED>(b, program, &scratch.own);
            downdate::<FUSED>(b, program, &sums.y, &mut sums.reduction);
        }
    }
}

impl Sums {
    /// `Y` from `J_bᵀ [r J_s]`, transposed into panels.
    #[inline(always)]
    fn solve_columns<const FUSED: bool>(&mut self, b: usize, program: &Program, factor: &[Lanes]) {
        for (p, &first) in program.first.iter().enumerate() {
            let panel = &mut self.columns[program.starts[p]..program.starts[p + 1]];
            triangle::forward_panel::<FUSED>(factor, first, panel);
            let out = &mut self.y[p * b * LANES..][first * LANES..b * LANES];
            for (out, [c0, c1, c2, c3]) in out.as_chunks_mut::<LANES>().0.iter_mut().zip(&*panel) {
                for (lane, out) in out.iter_mut().enumerate() {
                    *out = [c0.0[lane], c1.0[lane], c2.0[lane], c3.0[lane]];
                }
            }
        }
    }
}
