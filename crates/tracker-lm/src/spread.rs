//! Rows of a bordered problem with every column.

use least_squares::{BlockRows, BorderedPoint, BorderedProblem};
use nalgebra::DMatrix;

/// A bordered problem that says which columns its rows fill.
pub(crate) trait Columns: BorderedProblem {
    /// Rows of a block that are ranges: its first.
    fn range_count(&self, block: usize) -> usize;

    /// Block and shared directions of every row of a block.
    fn columns(&self, block: usize) -> Vec<(Vec<usize>, Vec<usize>)>;
}

/// Whitened rows of one block.
#[derive(Clone, Debug)]
pub(crate) struct DenseBlock {
    /// `rows × shared`.
    pub(crate) by_shared: DMatrix<f64>,
}

/// Residuals and derivatives of one block, with every column.
pub(crate) fn dense_block(problem: &impl Columns, at: &BorderedPoint, block: usize) -> DenseBlock {
    let columns = problem.columns(block);
    let m = problem.block_dim();
    let mut residuals = vec![0.0; columns.len()];
    let mut own = vec![0.0; columns.iter().map(|(b, _)| b.len()).sum()];
    let mut shared = vec![0.0; columns.iter().map(|(_, s)| s.len()).sum()];
    let rows = BlockRows { residuals: &mut residuals, by_block: &mut own, by_shared: &mut shared };
    problem.linearise(block, &at.shared, &at.blocks[m * block..m * (block + 1)], rows);
    let mut by_shared = DMatrix::zeros(columns.len(), problem.shared_dim());
    let mut next_shared = shared.into_iter();
    for (row, (_, of_shared)) in columns.iter().enumerate() {
        for (&column, value) in of_shared.iter().zip(next_shared.by_ref()) {
            by_shared[(row, column)] = value;
        }
    }
    DenseBlock { by_shared }
}
