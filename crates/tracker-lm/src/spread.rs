//! Uncertainty of anything that is linear in the shared parameters and those of blocks.

use least_squares::{BlockRows, BorderedPoint, BorderedProblem};
use nalgebra::{DMatrix, DVector};

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
    pub(crate) residual: DVector<f64>,
    /// `rows × shared`.
    pub(crate) by_shared: DMatrix<f64>,
    /// `rows × block`.
    pub(crate) by_block: DMatrix<f64>,
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
    let mut by_block = DMatrix::zeros(columns.len(), m);
    let mut by_shared = DMatrix::zeros(columns.len(), problem.shared_dim());
    let (mut next_own, mut next_shared) = (own.into_iter(), shared.into_iter());
    for (row, (of_block, of_shared)) in columns.iter().enumerate() {
        for (&column, value) in of_block.iter().zip(next_own.by_ref()) {
            by_block[(row, column)] = value;
        }
        for (&column, value) in of_shared.iter().zip(next_shared.by_ref()) {
            by_shared[(row, column)] = value;
        }
    }
    DenseBlock { residual: DVector::from_vec(residuals), by_shared, by_block }
}

/// Covariance of a solved bordered problem, kept in factors.
#[derive(Clone, Debug)]
pub(crate) struct Spread {
    /// Covariance of the shared parameters.
    pub(crate) shared: DMatrix<f64>,
    /// One per block; `None` where it is held.
    blocks: Vec<Option<Own>>,
}

/// How a block follows the shared parameters, and its uncertainty where these are known.
#[derive(Clone, Debug)]
struct Own {
    /// `∂ block / ∂ shared` at the minimum over the block.
    follows: DMatrix<f64>,
    /// Covariance with the shared parameters fixed.
    covariance: DMatrix<f64>,
}

impl Spread {
    /// From the covariance of the shared parameters; `held` blocks do not move.
    pub(crate) fn new(
        problem: &impl Columns,
        at: &BorderedPoint,
        shared: DMatrix<f64>,
        held: &[usize],
    ) -> Self {
        let own = |block: usize| {
            if held.contains(&block) {
                return None;
            }
            let rows = dense_block(problem, at, block);
            let qr = rows.by_block.qr();
            let r = qr.r();
            let inverse = r.try_inverse()?;
            let follows = -(&inverse * qr.q().tr_mul(&rows.by_shared));
            Some(Own { follows, covariance: &inverse * inverse.transpose() })
        };
        Self { shared, blocks: (0..problem.block_count()).map(own).collect() }
    }

    /// Covariance of `Σ Aₖ·blockₖ + B·shared`, every block at most once.
    pub(crate) fn of(
        &self,
        terms: &[(usize, DMatrix<f64>)],
        by_shared: Option<&DMatrix<f64>>,
    ) -> DMatrix<f64> {
        let rows = terms.first().map(|(_, a)| a.nrows()).or(by_shared.map(DMatrix::nrows));
        let rows = rows.unwrap_or(0);
        let mut along =
            by_shared.cloned().unwrap_or_else(|| DMatrix::zeros(rows, self.shared.nrows()));
        let mut covariance = DMatrix::zeros(rows, rows);
        for (block, a) in terms {
            if let Some(own) = &self.blocks[*block] {
                along += a * &own.follows;
                covariance += a * &own.covariance * a.transpose();
            }
        }
        covariance + &along * &self.shared * along.transpose()
    }
}
