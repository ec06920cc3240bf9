//! Products of tall matrices with transposed ones.

use nalgebra::{DMatrix, DMatrixView};

/// Rows that are taken together: those of some hundred columns stay in a processor's cache.
const TOGETHER: usize = 256;

/// Columns from which on a product of matrices is faster than products of vectors.
const MANY: usize = 6;

/// `AᵀB`, without a transposed copy of the whole.
pub(crate) fn tr_times(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    tr_times_of(a.as_view(), b.as_view())
}

/// `AᵀA`.
pub(crate) fn gram(a: &DMatrix<f64>) -> DMatrix<f64> {
    tr_times(a, a)
}

/// [`tr_times`] of views.
pub(crate) fn tr_times_of(a: DMatrixView<'_, f64>, b: DMatrixView<'_, f64>) -> DMatrix<f64> {
    let mut product = DMatrix::zeros(a.ncols(), b.ncols());
    for start in (0..a.nrows()).step_by(TOGETHER) {
        let rows = TOGETHER.min(a.nrows() - start);
        let (a, b) = (a.rows(start, rows), b.rows(start, rows));
        if b.ncols() < MANY {
            product.gemm_tr(1.0, &a, &b, 1.0);
        } else {
            product.gemm(1.0, &a.transpose(), &b, 1.0);
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::count::count;

    /// Of sums of some hundred products of numbers near one.
    const ROUND_OFF: f64 = 1e-12;

    #[test]
    fn products_are_what_their_sums_are() {
        let wave = |of: f64| move |i: usize, j: usize| (of * count(3 * i + 7 * j + 1)).sin();
        for (rows, left, right) in [(600, 4, 3), (600, 3, 9), (1, 1, 5), (6, 0, 2), (0, 2, 2)] {
            let (a, b) =
                (DMatrix::from_fn(rows, left, wave(0.7)), DMatrix::from_fn(rows, right, wave(1.3)));
            let product = tr_times(&a, &b);
            assert_eq!(product.shape(), (left, right));
            assert!((&product - a.tr_mul(&b)).iter().all(|off| off.abs() < ROUND_OFF));
            assert!((gram(&a) - a.tr_mul(&a)).iter().all(|off| off.abs() < ROUND_OFF));
        }
    }
}
