//! Refuses input that does not fit together.

use crate::SolveError;
use crate::bordered::{BorderedOptions, BorderedPoint, BorderedProblem, Pattern};

type Checked = Result<(), SolveError<BorderedPoint>>;

pub(super) fn check<P: BorderedProblem>(
    problem: &P,
    point: &BorderedPoint,
    options: &BorderedOptions,
) -> Checked {
    let (shared_dim, block_dim) = (problem.shared_dim(), problem.block_dim());
    let block_count = problem.block_count();
    check_options(options, shared_dim, block_count)?;
    for (index, pattern) in problem.patterns().iter().enumerate() {
        check_pattern(index, pattern, block_dim, shared_dim)?;
    }
    let pattern_count = problem.patterns().len();
    let patterns = (0..block_count).map(|k| problem.pattern_of(k));
    if let Some(pattern) = patterns.into_iter().find(|pattern| *pattern >= pattern_count) {
        return Err(SolveError::InvalidPattern { pattern, row: 0, direction: 0 });
    }
    let block_len = point.block_len(block_count);
    if block_len * block_count != point.blocks.len()
        || (block_dim > 0 && block_count > 0 && block_len == 0)
    {
        let (numbers, blocks) = (point.blocks.len(), block_count);
        return Err(SolveError::InvalidBlocks { numbers, blocks });
    }
    if !problem.is_point(point) {
        return Err(SolveError::InvalidStart);
    }
    Ok(())
}

fn check_options(options: &BorderedOptions, shared_dim: usize, block_count: usize) -> Checked {
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
fn check_pattern(index: usize, pattern: &Pattern, block_dim: usize, shared_dim: usize) -> Checked {
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
