//! Singular values in order, of the small matrices here.

use nalgebra::{DMatrix, SMatrix, SVector};

/// `A = U diag(values) Vᵀ`, the largest value first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Singular<const D: usize> {
    pub(crate) u: SMatrix<f64, D, D>,
    pub(crate) values: SVector<f64, D>,
    pub(crate) v: SMatrix<f64, D, D>,
}

/// A matrix of run-time size, for the decompositions that need one.
pub(crate) fn dynamic<const R: usize, const C: usize>(matrix: &SMatrix<f64, R, C>) -> DMatrix<f64> {
    DMatrix::from_column_slice(R, C, matrix.as_slice())
}

/// Singular value decomposition of a square matrix; all NaN where an entry is not finite.
pub(crate) fn singular<const D: usize>(matrix: &SMatrix<f64, D, D>) -> Singular<D> {
    if matrix.iter().any(|v| !v.is_finite()) {
        let nan = SMatrix::repeat(f64::NAN);
        return Singular { u: nan, values: SVector::repeat(f64::NAN), v: nan };
    }
    let svd = dynamic(matrix).svd(true, true);
    let (u, v_t) = (svd.u.expect("requested"), svd.v_t.expect("requested"));
    let mut order: Vec<usize> = (0..D).collect();
    order.sort_by(|&a, &b| svd.singular_values[b].total_cmp(&svd.singular_values[a]));
    Singular {
        u: SMatrix::from_fn(|row, k| u[(row, order[k])]),
        values: SVector::from_fn(|k, _| svd.singular_values[order[k]]),
        v: SMatrix::from_fn(|row, k| v_t[(order[k], row)]),
    }
}

pub(crate) fn determinant<const D: usize>(matrix: &SMatrix<f64, D, D>) -> f64 {
    dynamic(matrix).determinant()
}
