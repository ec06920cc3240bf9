//! Patterns made ready for the elimination: which product of numbers goes where.

mod check;
mod compiled;

pub(super) use compiled::{Compiled, Limits, Products, Sum};

use super::lanes::LANES;
use super::{BorderedOptions, BorderedPoint, BorderedProblem, Pattern};
use crate::SolveError;

/// Columns that the rank update handles together.
pub(super) const PANEL: usize = 4;

/// Sizes, patterns and the order of the shared columns.
///
/// Column 0 is the residual; column `1 + i` is the `i`-th free shared direction. The latter are
/// ordered by the first block direction they meet, so that the zeros above it lie together.
#[derive(Debug)]
pub(super) struct Program {
    pub(super) block_dim: usize,
    pub(super) shared_dim: usize,
    pub(super) block_count: usize,
    /// Shared direction of each column but the first.
    pub(super) free: Vec<usize>,
    /// First block direction that any column of each panel meets.
    pub(super) first: Vec<usize>,
    /// Rows of each panel, from that direction on, among those of all panels; then their end.
    pub(super) starts: Vec<usize>,
    /// Pairs of columns whose product some row has.
    pub(super) slots: Vec<[usize; 2]>,
    pub(super) patterns: Vec<Compiled>,
    /// Whether each block is held; empty where none is.
    held: Vec<bool>,
    /// Pattern of each block; empty where there is one only.
    pattern_of: Vec<usize>,
    /// Blocks in the order in which they are handled; empty where that is their own.
    order: Vec<usize>,
    pub(super) limits: Limits,
}

impl Program {
    pub(super) fn new<P: BorderedProblem>(
        problem: &P,
        point: &BorderedPoint,
        options: &BorderedOptions,
    ) -> Result<Self, SolveError<BorderedPoint>> {
        check::check(problem, point, options)?;
        let (shared_dim, block_dim) = (problem.shared_dim(), problem.block_dim());
        let block_count = problem.block_count();
        let first_met = first_met(problem.patterns(), shared_dim, block_dim);
        let mut is_free = vec![true; shared_dim];
        for &direction in &options.held_shared {
            is_free[direction] = false;
        }
        let mut free: Vec<usize> = (0..shared_dim).filter(|i| is_free[*i]).collect();
        free.sort_by_key(|&i| first_met[i]);
        let mut column_of = vec![None; shared_dim];
        for (i, &direction) in free.iter().enumerate() {
            column_of[direction] = Some(1 + i);
        }
        let mut of_columns = vec![0];
        of_columns.extend(free.iter().map(|&direction| first_met[direction]));
        let panels = of_columns.chunks(PANEL);
        let first: Vec<usize> = panels.map(|p| p.iter().copied().min().unwrap_or(0)).collect();
        let mut starts = vec![0];
        for (p, first) in first.iter().enumerate() {
            starts.push(starts[p] + block_dim - first);
        }
        let mut slots = compiled::Slots::default();
        let compile = |pattern| Compiled::new(pattern, &column_of, &first, &starts, &mut slots);
        let patterns: Vec<_> = problem.patterns().iter().map(compile).collect();
        let limits = Limits::most(&patterns);
        let mut held = Vec::new();
        if !options.held_blocks.is_empty() {
            held.resize(block_count, false);
            options.held_blocks.iter().for_each(|&k| held[k] = true);
        }
        let mut pattern_of = Vec::new();
        if patterns.len() > 1 {
            pattern_of.extend((0..block_count).map(|k| problem.pattern_of(k)));
        }
        let slots = slots.pairs;
        Ok(Self {
            block_dim,
            shared_dim,
            block_count,
            free,
            first,
            starts,
            slots,
            patterns,
            held,
            pattern_of,
            order: Vec::new(),
            limits,
        })
    }

    /// Lets blocks of one kind follow each other in every chunk of so many blocks.
    pub(super) fn sort_chunks(&mut self, length: usize) {
        if self.held.is_empty() && self.pattern_of.is_empty() {
            return;
        }
        let mut order: Vec<usize> = (0..self.block_count).collect();
        for chunk in order.chunks_mut(length) {
            chunk.sort_by_key(|&k| self.kind(k));
        }
        self.order = order;
    }

    fn kind(&self, block: usize) -> (bool, usize) {
        (self.is_held(block), self.pattern_of.get(block).copied().unwrap_or(0))
    }

    pub(super) fn is_held(&self, block: usize) -> bool {
        self.held.get(block).copied().unwrap_or(false)
    }

    pub(super) fn compiled(&self, block: usize) -> &Compiled {
        &self.patterns[self.kind(block).1]
    }

    /// The blocks of one kind that are handled together from a place in the order on.
    pub(super) fn group(&self, from: usize, end: usize) -> Group {
        let block = |at: usize| self.order.get(at).copied().unwrap_or(at);
        self.together(block(from), (from + 1..end).map(block))
    }

    /// A block, and of those that follow it the ones of its kind that are handled together with it.
    pub(super) fn together(&self, first: usize, others: impl Iterator<Item = usize>) -> Group {
        let kind = self.kind(first);
        let mut group = Group { blocks: [first; LANES], count: 1, is_held: kind.0 };
        for other in others.take(LANES - 1).take_while(|&other| self.kind(other) == kind) {
            group.blocks[group.count] = other;
            group.count += 1;
        }
        group
    }

    /// Free directions of all blocks and of the shared point.
    pub(super) fn parameters(&self) -> usize {
        let held = self.held.iter().filter(|h| **h).count();
        self.free.len() + (self.block_count - held) * self.block_dim
    }
}

/// Up to four blocks of one pattern.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    /// Those from `count` on repeat the first.
    pub(super) blocks: [usize; LANES],
    pub(super) count: usize,
    pub(super) is_held: bool,
}

/// Least block direction in a row with each shared direction; `block_dim` where there is none.
fn first_met(patterns: &[Pattern], shared_dim: usize, block_dim: usize) -> Vec<usize> {
    let mut first = vec![block_dim; shared_dim];
    for row in patterns.iter().flat_map(Pattern::rows) {
        let Some(&least) = row.of_block.iter().min() else { continue };
        for &direction in &row.of_shared {
            first[direction] = first[direction].min(least);
        }
    }
    first
}
