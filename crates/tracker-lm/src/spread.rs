//! Rows of the joint bundle with every column.

use least_squares::{BlockRows, BorderedPoint, BorderedProblem};
use nalgebra::DMatrix;

use crate::joint::Joint;

/// Whitened rows of one block.
#[derive(Clone, Debug)]
pub(crate) struct DenseBlock {
    /// `rows × shared`.
    pub(crate) by_shared: DMatrix<f64>,
}

/// Derivatives of one block by all that blocks share, with every column.
pub(crate) fn dense_block(joint: &Joint<'_>, at: &BorderedPoint, block: usize) -> DenseBlock {
    let columns: Vec<Vec<usize>> =
        joint.ranges_of.at(block).iter().map(|&range| joint.shared_of(range as usize)).collect();
    let m = joint.block_dim();
    let mut residuals = vec![0.0; columns.len()];
    let mut own = vec![0.0; m * columns.len()];
    let mut shared = vec![0.0; columns.iter().map(Vec::len).sum()];
    let rows = BlockRows { residuals: &mut residuals, by_block: &mut own, by_shared: &mut shared };
    joint.linearise(block, &at.shared, &at.blocks[m * block..m * (block + 1)], rows);
    let mut by_shared = DMatrix::zeros(columns.len(), joint.shared_dim());
    let mut next_shared = shared.into_iter();
    for (row, of_shared) in columns.iter().enumerate() {
        for (&column, value) in of_shared.iter().zip(next_shared.by_ref()) {
            by_shared[(row, column)] = value;
        }
    }
    DenseBlock { by_shared }
}
