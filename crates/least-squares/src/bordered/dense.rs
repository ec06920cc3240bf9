use nalgebra::{DMatrix, DVector};

use super::{BlockRows, BorderedPoint, BorderedProblem};
use crate::Problem;

/// A bordered problem as the dense solver sees it, for [`check_jacobian`] and for comparison.
///
/// Rows are those of the blocks in turn, then the shared ones; directions are the shared ones,
/// then those of the blocks in turn. Its Jacobian is mostly zeros: for a few blocks only.
///
/// [`check_jacobian`]: crate::check_jacobian
#[derive(Clone, Copy, Debug)]
pub struct AsDense<'a, P>(pub &'a P);

impl<P: BorderedProblem> AsDense<'_, P> {
    fn rows_of(&self, block: usize) -> usize {
        self.0.patterns()[self.0.pattern_of(block)].residual_count()
    }

    /// Residuals and derivatives of one block by rows, NaN where the problem writes nothing.
    fn linearise(&self, block: usize, at: &BorderedPoint) -> [Vec<f64>; 3] {
        let pattern = &self.0.patterns()[self.0.pattern_of(block)];
        let block_len = at.block_len(self.0.block_count());
        let by_block = pattern.rows().iter().map(|r| r.of_block.len()).sum();
        let by_shared = pattern.rows().iter().map(|r| r.of_shared.len()).sum();
        let mut numbers =
            [pattern.residual_count(), by_block, by_shared].map(|n| vec![f64::NAN; n]);
        let [residuals, by_block, by_shared] = &mut numbers;
        let rows = BlockRows { residuals, by_block, by_shared };
        let point = &at.blocks[block * block_len..][..block_len];
        self.0.linearise(block, &at.shared, point, rows);
        numbers
    }
}

impl<P: BorderedProblem> Problem for AsDense<'_, P> {
    type Point = BorderedPoint;

    fn residual_count(&self) -> usize {
        let of_blocks: usize = (0..self.0.block_count()).map(|k| self.rows_of(k)).sum();
        of_blocks + self.0.shared_residual_count()
    }

    fn tangent_dim(&self) -> usize {
        self.0.shared_dim() + self.0.block_count() * self.0.block_dim()
    }

    fn residuals(&self, at: &BorderedPoint, out: &mut DVector<f64>) {
        let block_len = at.block_len(self.0.block_count());
        let mut rest = out.as_mut_slice();
        for block in 0..self.0.block_count() {
            let (rows, after) = rest.split_at_mut(self.rows_of(block));
            let point = &at.blocks[block * block_len..][..block_len];
            self.0.residuals(block, &at.shared, point, rows);
            rest = after;
        }
        if !rest.is_empty() {
            let mut jacobian = vec![0.0; rest.len() * self.0.shared_dim()];
            self.0.linearise_shared(&at.shared, rest, &mut jacobian);
        }
    }

    fn jacobian(&self, at: &BorderedPoint, out: &mut DMatrix<f64>) {
        let (n, b) = (self.0.shared_dim(), self.0.block_dim());
        let mut row = 0;
        for block in 0..self.0.block_count() {
            let [_, by_block, by_shared] = self.linearise(block, at);
            let (mut by_block, mut by_shared) = (by_block.iter(), by_shared.iter());
            let pattern = &self.0.patterns()[self.0.pattern_of(block)];
            for listed in pattern.rows() {
                for (&direction, value) in listed.of_block.iter().zip(&mut by_block) {
                    out[(row, n + block * b + direction)] = *value;
                }
                for (&direction, value) in listed.of_shared.iter().zip(&mut by_shared) {
                    out[(row, direction)] = *value;
                }
                row += 1;
            }
        }
        let count = self.0.shared_residual_count();
        if count > 0 {
            let (mut residuals, mut jacobian) = (vec![0.0; count], vec![f64::NAN; count * n]);
            self.0.linearise_shared(&at.shared, &mut residuals, &mut jacobian);
            for (i, derivatives) in jacobian.chunks_exact(n).enumerate() {
                for (j, value) in derivatives.iter().enumerate() {
                    out[(row + i, j)] = *value;
                }
            }
        }
    }

    fn retract(&self, at: &BorderedPoint, step: &DVector<f64>) -> BorderedPoint {
        let (n, b) = (self.0.shared_dim(), self.0.block_dim());
        let block_len = at.block_len(self.0.block_count());
        let step = step.as_slice();
        let mut moved = at.clone();
        self.0.retract_shared(&at.shared, &step[..n], &mut moved.shared);
        for block in 0..self.0.block_count() {
            let numbers = block * block_len..(block + 1) * block_len;
            let step = &step[n + block * b..][..b];
            let (old, new) = (&at.blocks[numbers.clone()], &mut moved.blocks[numbers]);
            self.0.retract_block(block, old, step, new);
        }
        moved
    }

    fn parameter_name(&self, index: usize) -> String {
        let (n, b) = (self.0.shared_dim(), self.0.block_dim());
        match index.checked_sub(n) {
            Some(of_blocks) => self.0.block_name(of_blocks / b, of_blocks % b),
            None => self.0.shared_name(index),
        }
    }
}
