#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use super::{BlockRows, BorderedPoint, Pattern};

/// Residuals of many small independent blocks that share a few parameters.
///
/// Each block has a point of its own, and residuals that depend on that point and on the shared
/// one, but on no other block: a target per step seen from a few stations, a pose per scan under
/// one calibration, a baseline per spectrum on one instrument. Residuals are *whitened*: each
/// divided by its standard uncertainty.
///
/// Points are plain numbers, so that all blocks lie in one piece of memory. Where they live on a
/// manifold, say a pose as quaternion and translation, they hold more numbers than a step has,
/// and [`BorderedProblem::retract_block`] moves them.
///
/// Methods are called from several threads. Mark those that compute residuals
/// `#[inline(always)]` to have them compiled for the vector instructions that the solver finds
/// at run time.
pub trait BorderedProblem: Sync {
    /// Degrees of freedom of a step of the shared point.
    fn shared_dim(&self) -> usize;

    /// Degrees of freedom of a step of one block; the same for all.
    fn block_dim(&self) -> usize;

    /// Number of blocks.
    fn block_count(&self) -> usize;

    /// What the rows of blocks depend on. Blocks of one kind have one pattern.
    fn patterns(&self) -> &[Pattern];

    /// Index into [`BorderedProblem::patterns`] of one block.
    fn pattern_of(&self, block: usize) -> usize {
        let _ = block;
        0
    }

    /// Residuals of one block that are there: fewer than its pattern's rows where the problem
    /// writes absent rows as noughts.
    fn observed_count(&self, block: usize) -> usize {
        self.patterns()[self.pattern_of(block)].residual_count()
    }

    /// Writes the whitened residuals of one block, one per row of its pattern.
    fn residuals(&self, block: usize, shared: &[f64], point: &[f64], out: &mut [f64]);

    /// Writes the whitened residuals of one block and their derivatives.
    ///
    /// `rows` holds arbitrary numbers before: everything in it has to be written. An absent row
    /// is nought in all its parts, here and in [`BorderedProblem::residuals`], and missing from
    /// [`BorderedProblem::observed_count`].
    fn linearise(&self, block: usize, shared: &[f64], point: &[f64], rows: BlockRows<'_>);

    /// Number of residuals that depend on the shared point alone, such as priors.
    fn shared_residual_count(&self) -> usize {
        0
    }

    /// Writes the residuals that depend on the shared point alone, and their derivatives as rows
    /// of `shared_dim` numbers. Both hold arbitrary numbers before.
    fn linearise_shared(&self, shared: &[f64], residuals: &mut [f64], jacobian: &mut [f64]) {
        let _ = (shared, residuals, jacobian);
    }

    /// Moves the shared point by a tangent step.
    fn retract_shared(&self, shared: &[f64], step: &[f64], out: &mut [f64]) {
        add(shared, step, out);
    }

    /// Moves the point of one block by a tangent step.
    #[inline(always)]
    fn retract_block(&self, block: usize, point: &[f64], step: &[f64], out: &mut [f64]) {
        let _ = block;
        add(point, step, out);
    }

    /// Whether `point` is one of this problem: whether it has as many numbers as it should.
    ///
    /// A start that is none is [`SolveError::InvalidStart`](crate::SolveError::InvalidStart) instead of
    /// a panic in the residuals. Unless you write another rule, shared point and blocks have one number
    /// per degree of freedom. Write one where they hold more numbers than a step, such as a unit
    /// quaternion.
    fn is_point(&self, point: &BorderedPoint) -> bool {
        point.shared.len() == self.shared_dim()
            && point.blocks.len() == self.block_dim() * self.block_count()
    }

    /// Name of one shared tangent direction with its unit, for errors and reports.
    fn shared_name(&self, index: usize) -> String {
        format!("shared parameter {index}")
    }

    /// Name of one tangent direction of a block with its unit, for errors and reports.
    fn block_name(&self, block: usize, index: usize) -> String {
        format!("parameter {index} of block {block}")
    }
}

#[inline(always)]
fn add(point: &[f64], step: &[f64], out: &mut [f64]) {
    for ((out, p), s) in out.iter_mut().zip(point).zip(step) {
        *out = p + s;
    }
}
