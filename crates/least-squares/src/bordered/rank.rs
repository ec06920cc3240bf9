//! Which directions the data leave free.

use nalgebra::{DMatrix, DVector};

use super::BorderedProblem;
use super::block::{Place, Rows};
use super::orthogonal::{BlockFactor, SharedFactor};
use crate::FreeDirection;
use crate::factorisation::singular_values;
use crate::null_space::free_directions;

/// Blocks with free directions of their own that are named; more would say no more.
const MAX_BLOCKS: usize = 3;

/// Rank of the shared columns, and what lies outside it.
pub(super) struct Rank {
    pub(super) directions: Vec<FreeDirection>,
    /// Condition number of the column-scaled shared triangle.
    pub(super) condition: f64,
}

impl<P: BorderedProblem> Place<'_, P> {
    /// Judges the blocks each on its own, then the shared point.
    pub(super) fn rank(&self, shared: &SharedFactor, tolerance: f64) -> Rank {
        let of_blocks = self.free_in_blocks(tolerance);
        if !of_blocks.is_empty() {
            return Rank { directions: of_blocks, condition: f64::INFINITY };
        }
        let scale = shared.lengths();
        let mut scaled = shared.triangle();
        for (mut column, s) in scaled.column_iter_mut().zip(&scale) {
            column.unscale_mut(*s);
        }
        let (values, null_space) = weak(&scaled, tolerance);
        let (largest, smallest) = (values.max(), values.min());
        let condition = if values.is_empty() { 1.0 } else { largest / smallest };
        let n = self.program.shared_dim;
        let name = |index| self.problem.shared_name(index);
        let mut directions = free_directions(&null_space, &scale, &self.program.free, n, name);
        for direction in &mut directions {
            direction.step = self.with_blocks(&direction.step);
        }
        Rank { directions, condition }
    }

    /// A step of the shared point with the steps of all blocks that go with it.
    fn with_blocks(&self, shared: &DVector<f64>) -> DVector<f64> {
        let (n, b) = (self.program.shared_dim, self.program.block_dim);
        let mut step = DVector::zeros(n + self.program.block_count * b);
        step.rows_mut(0, n).copy_from(shared);
        let columns =
            DVector::from_fn(self.program.free.len(), |k, _| shared[self.program.free[k]]);
        let mut numbers = Rows::new(self.program.limits);
        for block in (0..self.program.block_count).filter(|&k| !self.program.is_held(k)) {
            let of_block = -(self.factor(&mut numbers, block).coupling() * &columns);
            step.rows_mut(n + block * b, b).copy_from(&of_block);
        }
        step
    }

    fn free_in_blocks(&self, tolerance: f64) -> Vec<FreeDirection> {
        let (n, b) = (self.program.shared_dim, self.program.block_dim);
        let mut numbers = Rows::new(self.program.limits);
        let mut directions = Vec::new();
        let mut blocks = 0;
        for block in (0..self.program.block_count).filter(|&k| !self.program.is_held(k)) {
            let factor = self.factor(&mut numbers, block);
            let (null_space, scale) = free_in_block(&factor, tolerance);
            if null_space.ncols() == 0 {
                continue;
            }
            let name = |index| self.problem.block_name(block, index);
            let own: Vec<usize> = (0..b).collect();
            for mut direction in free_directions(&null_space, &scale, &own, b, name) {
                let mut step = DVector::zeros(n + self.program.block_count * b);
                step.rows_mut(n + block * b, b).copy_from(&direction.step);
                direction.step = step;
                directions.push(direction);
            }
            blocks += 1;
            if blocks == MAX_BLOCKS {
                break;
            }
        }
        directions
    }
}

/// Null space of a block's unit columns, and their lengths.
fn free_in_block(factor: &BlockFactor, tolerance: f64) -> (DMatrix<f64>, DVector<f64>) {
    let scale = factor.lengths.map(|s| if s > 0.0 { s } else { 1.0 });
    let mut scaled = factor.triangle();
    for (mut column, s) in scaled.column_iter_mut().zip(&scale) {
        column.unscale_mut(*s);
    }
    (weak(&scaled, tolerance).1, scale)
}

/// Singular values, and the right singular vectors of those that count as nought.
fn weak(triangle: &DMatrix<f64>, tolerance: f64) -> (DVector<f64>, DMatrix<f64>) {
    let (values, v_t) = singular_values(triangle);
    let largest = values.iter().copied().fold(0.0, f64::max);
    let weak: Vec<usize> =
        (0..values.len()).filter(|&i| values[i] <= tolerance * largest || largest == 0.0).collect();
    let null_space = DMatrix::from_fn(values.len(), weak.len(), |i, k| v_t[(weak[k], i)]);
    (values, null_space)
}
