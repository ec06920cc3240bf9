//! Patterns made ready for the elimination: which number goes where.

use std::ops::Range;

use super::{BorderedOptions, BorderedPoint, BorderedProblem, Pattern};
use crate::SolveError;

/// Columns that the elimination handles together; the width is a multiple of it.
pub(super) const TILE: usize = 8;

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
    /// Columns, padded to whole tiles.
    pub(super) width: usize,
    /// First block direction that any column of a tile meets.
    pub(super) first: Vec<usize>,
    pub(super) patterns: Vec<Compiled>,
    /// Whether each block is held; empty where none is.
    pub(super) held: Vec<bool>,
    pub(super) limits: Limits,
}

/// Most numbers that a block of any pattern has.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Limits {
    pub(super) rows: usize,
    pub(super) by_block: usize,
    pub(super) by_shared: usize,
}

/// One pattern.
#[derive(Debug)]
pub(super) struct Compiled {
    pub(super) rows: Vec<Row>,
    /// Block direction of each number in `by_block`.
    pub(super) block_columns: Vec<usize>,
    /// Numbers of `by_shared` whose direction is free, by row and column.
    pub(super) entries: Vec<Entry>,
    pub(super) limits: Limits,
}

#[derive(Debug)]
pub(super) struct Row {
    pub(super) by_block: Range<usize>,
    pub(super) entries: Range<usize>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) value: usize,
    pub(super) column: usize,
}

impl Program {
    pub(super) fn new<P: BorderedProblem>(
        problem: &P,
        point: &BorderedPoint,
        options: &BorderedOptions,
    ) -> Result<Self, SolveError<BorderedPoint>> {
        let (shared_dim, block_dim) = (problem.shared_dim(), problem.block_dim());
        let block_count = problem.block_count();
        check_options(options, shared_dim, block_count)?;
        for (index, pattern) in problem.patterns().iter().enumerate() {
            check_pattern(index, pattern, block_dim, shared_dim)?;
        }
        let pattern_count = problem.patterns().len();
        if let Some(block) = (0..block_count).find(|&k| problem.pattern_of(k) >= pattern_count) {
            let pattern = problem.pattern_of(block);
            return Err(SolveError::InvalidPattern { pattern, row: 0, direction: 0 });
        }
        let block_len = point.block_len(block_count);
        if block_len * block_count != point.blocks.len()
            || (block_dim > 0 && block_count > 0 && block_len == 0)
        {
            let (numbers, blocks) = (point.blocks.len(), block_count);
            return Err(SolveError::InvalidBlocks { numbers, blocks });
        }
        Ok(Self::compile(problem, options))
    }

    fn compile<P: BorderedProblem>(problem: &P, options: &BorderedOptions) -> Self {
        let (shared_dim, block_dim) = (problem.shared_dim(), problem.block_dim());
        let first_met = first_met(problem.patterns(), shared_dim, block_dim);
        let mut free: Vec<usize> =
            (0..shared_dim).filter(|i| !options.held_shared.contains(i)).collect();
        free.sort_by_key(|&i| first_met[i]);
        let width = (1 + free.len()).next_multiple_of(TILE);
        let mut first = vec![block_dim; width / TILE];
        first[0] = 0;
        let mut column_of = vec![None; shared_dim];
        for (i, &direction) in free.iter().enumerate() {
            column_of[direction] = Some(1 + i);
            let tile = &mut first[(1 + i) / TILE];
            *tile = (*tile).min(first_met[direction]);
        }
        let patterns: Vec<_> =
            problem.patterns().iter().map(|p| Compiled::new(p, &column_of)).collect();
        let most = |part: fn(&Limits) -> usize| {
            patterns.iter().map(|p| part(&p.limits)).max().unwrap_or(0)
        };
        let limits = Limits {
            rows: most(|l| l.rows),
            by_block: most(|l| l.by_block),
            by_shared: most(|l| l.by_shared),
        };
        let mut held = Vec::new();
        if !options.held_blocks.is_empty() {
            held.resize(problem.block_count(), false);
            options.held_blocks.iter().for_each(|&k| held[k] = true);
        }
        let block_count = problem.block_count();
        Self { block_dim, shared_dim, block_count, free, width, first, patterns, held, limits }
    }

    pub(super) fn is_held(&self, block: usize) -> bool {
        self.held.get(block).copied().unwrap_or(false)
    }

    /// Free directions of all blocks and of the shared point.
    pub(super) fn parameters(&self) -> usize {
        let held = self.held.iter().filter(|h| **h).count();
        self.free.len() + (self.block_count - held) * self.block_dim
    }
}

impl Compiled {
    fn new(pattern: &Pattern, column_of: &[Option<usize>]) -> Self {
        let (mut rows, mut block_columns) = (Vec::new(), Vec::new());
        let (mut entries, mut value) = (Vec::new(), 0);
        for row in pattern.rows() {
            let (block_start, entry_start) = (block_columns.len(), entries.len());
            block_columns.extend_from_slice(&row.of_block);
            for &direction in &row.of_shared {
                entries.extend(column_of[direction].map(|column| Entry { value, column }));
                value += 1;
            }
            entries[entry_start..].sort_by_key(|e: &Entry| e.column);
            rows.push(Row {
                by_block: block_start..block_columns.len(),
                entries: entry_start..entries.len(),
            });
        }
        let limits = Limits { rows: rows.len(), by_block: block_columns.len(), by_shared: value };
        Self { rows, block_columns, entries, limits }
    }
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

fn check_options(
    options: &BorderedOptions,
    shared_dim: usize,
    block_count: usize,
) -> Result<(), SolveError<BorderedPoint>> {
    if let Some(&index) = options.held_shared.iter().find(|&&i| i >= shared_dim) {
        return Err(SolveError::DirectionOutOfRange { index, tangent_dim: shared_dim });
    }
    if let Some(&block) = options.held_blocks.iter().find(|&&k| k >= block_count) {
        return Err(SolveError::BlockOutOfRange { block, block_count });
    }
    for (index, robust) in options.robust.iter().enumerate() {
        let (scale, block_rows) = (robust.loss.scale(), robust.block_rows);
        if !(scale > 0.0 && scale.is_finite()) || block_rows == 0 {
            return Err(SolveError::InvalidLoss { index, scale, block_rows });
        }
    }
    Ok(())
}

/// Every direction exists and none is listed twice in a row.
fn check_pattern(
    index: usize,
    pattern: &Pattern,
    block_dim: usize,
    shared_dim: usize,
) -> Result<(), SolveError<BorderedPoint>> {
    for (row, listed) in pattern.rows().iter().enumerate() {
        for (directions, dim) in [(&listed.of_block, block_dim), (&listed.of_shared, shared_dim)] {
            for (i, &direction) in directions.iter().enumerate() {
                if direction >= dim || directions[..i].contains(&direction) {
                    return Err(SolveError::InvalidPattern { pattern: index, row, direction });
                }
            }
        }
    }
    Ok(())
}
