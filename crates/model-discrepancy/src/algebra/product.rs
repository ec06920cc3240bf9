//! Products of matrices, by faer: of tall ones it takes a half to a quarter of nalgebra's time.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::DMatrix;

/// Rows of a triangle that are multiplied together.
const BLOCK: usize = 32;

/// The matrix, for faer.
pub(crate) fn view(matrix: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
}

/// `AB`.
pub(crate) fn times(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> DMatrix<f64> {
    let mut product = DMatrix::zeros(a.nrows(), b.ncols());
    add_times(view_mut(&mut product), 1.0, a, b);
    product
}

/// `AᵀB`.
pub(crate) fn tr_times(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    times(view(a).transpose(), view(b))
}

/// `AᵀA`.
pub(crate) fn gram(a: &DMatrix<f64>) -> DMatrix<f64> {
    tr_times(a, a)
}

/// Adds `factor·AB` to a matrix.
pub(crate) fn add_times(to: MatMut<'_, f64>, factor: f64, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    matmul(to, Accum::Add, a, b, factor, Par::Seq);
}

/// The matrix, for faer to write to.
pub(crate) fn view_mut(matrix: &mut DMatrix<f64>) -> MatMut<'_, f64> {
    let (rows, columns) = matrix.shape();
    MatMut::from_column_major_slice_mut(matrix.as_mut_slice(), rows, columns)
}

/// Of the first rows of a lower triangle, as many as there are rows in `columns`.
pub(crate) fn lower_triangular_times(rows: &DMatrix<f64>, columns: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, m) = columns.shape();
    let mut product = DMatrix::zeros(n, m);
    let mut to = view_mut(&mut product);
    for start in (0..n).step_by(BLOCK) {
        let some = BLOCK.min(n - start);
        let left = view(rows).submatrix(start, 0, some, start + some);
        let right = view(columns).subrows(0, start + some);
        matmul(to.as_mut().subrows_mut(start, some), Accum::Replace, left, right, 1.0, Par::Seq);
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
            let triangle =
                DMatrix::from_fn(rows, rows, |i, j| if j <= i { wave(0.9)(i, j) } else { 0.0 });
            let below = lower_triangular_times(&triangle, &a) - &triangle * &a;
            assert!(below.iter().all(|off| off.abs() < ROUND_OFF));
            let mut rest = b.clone();
            add_times(view_mut(&mut rest), -0.5, view(&a), view(&product));
            let whole = &b - 0.5 * (&a * &product);
            assert!((rest - whole).iter().all(|off| off.abs() < ROUND_OFF));
        }
    }
}
