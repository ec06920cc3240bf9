//! Pivoted QR and singular values of dense matrices: those of `faer` with the feature `bordered`,
//! which needs it anyway, else those of `nalgebra`.

use nalgebra::{DMatrix, DVector};

#[cfg(feature = "bordered")]
use faer_based as library;
#[cfg(not(feature = "bordered"))]
use nalgebra_based as library;

/// `R` and, for each of its columns, the column of `matrix`, which is not wider than high.
pub(crate) fn pivoted_qr(matrix: &DMatrix<f64>) -> (DMatrix<f64>, Vec<usize>) {
    library::pivoted_qr(matrix)
}

/// Singular values of a square matrix, descending, and its right singular vectors, transposed.
///
/// Where the iteration fails, which finite input has never made it do, all values are nought:
/// nothing is known of the rank, so nothing is claimed.
pub(crate) fn singular_values(r: &DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>) {
    let n = r.ncols();
    if n == 0 {
        return (DVector::zeros(0), DMatrix::zeros(0, 0));
    }
    library::singular_values(r).unwrap_or_else(|| (DVector::zeros(n), DMatrix::identity(n, n)))
}

#[cfg(feature = "bordered")]
mod faer_based {
    use faer::MatRef;
    use nalgebra::{DMatrix, DVector};

    fn view(matrix: &DMatrix<f64>) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
    }

    pub(super) fn pivoted_qr(matrix: &DMatrix<f64>) -> (DMatrix<f64>, Vec<usize>) {
        let columns = matrix.ncols();
        let qr = view(matrix).col_piv_qr();
        let upper = |i: usize, j: usize| if i <= j { qr.R()[(i, j)] } else { 0.0 };
        (DMatrix::from_fn(columns, columns, upper), qr.P().arrays().0.to_vec())
    }

    pub(super) fn singular_values(r: &DMatrix<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let n = r.ncols();
        let svd = view(r).svd().ok()?;
        let values = DVector::from_fn(n, |i, _| svd.S().column_vector()[i]);
        Some((values, DMatrix::from_fn(n, n, |i, j| svd.V()[(j, i)])))
    }
}

#[cfg(any(test, not(feature = "bordered")))]
mod nalgebra_based {
    use nalgebra::linalg::{ColPivQR, SVD};
    use nalgebra::{DMatrix, DVector, RowDVector};

    pub(super) fn pivoted_qr(matrix: &DMatrix<f64>) -> (DMatrix<f64>, Vec<usize>) {
        let columns = matrix.ncols();
        let qr = ColPivQR::new(matrix.clone());
        let mut order = RowDVector::from_fn(columns, |_, k| k);
        qr.p().permute_columns(&mut order);
        (qr.r(), order.iter().copied().collect())
    }

    pub(super) fn singular_values(r: &DMatrix<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let svd = SVD::try_new(r.clone(), false, true, f64::EPSILON, 0)?;
        Some((svd.singular_values, svd.v_t?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix of order one loses some digits per column.
    const ROUNDING: f64 = 1e-13;

    /// Seven by five, the last column almost in the span of the first two.
    fn matrix() -> DMatrix<f64> {
        let numbers = (0..35).map(|k| (0.37 * f64::from(k * k)).sin());
        let mut a = DMatrix::from_iterator(7, 5, numbers);
        let dependent = a.column(0) + a.column(1) * 0.5 + a.column(2) * 1e-9;
        a.set_column(4, &dependent);
        a
    }

    fn assert_factors((r, order): (DMatrix<f64>, Vec<usize>), a: &DMatrix<f64>) {
        let permuted = DMatrix::from_fn(a.nrows(), a.ncols(), |i, k| a[(i, order[k])]);
        assert_eq!(r.shape(), (5, 5));
        assert!((r.transpose() * &r - permuted.transpose() * &permuted).amax() < ROUNDING);
        assert!(r.iter().enumerate().all(|(at, v)| at % 5 <= at / 5 || *v == 0.0));
    }

    #[test]
    fn both_libraries_factor_alike() {
        let a = matrix();
        assert_factors(nalgebra_based::pivoted_qr(&a), &a);
        assert_factors(pivoted_qr(&a), &a);
    }

    #[test]
    fn both_libraries_find_the_same_singular_values_and_the_weak_direction() {
        let (r, _) = pivoted_qr(&matrix());
        let (values, v_t) = singular_values(&r);
        let (others, other_v_t) = nalgebra_based::singular_values(&r).expect("the iteration ends");
        assert!((&values - &others).amax() < ROUNDING);
        assert!(values[4] < 1e-8 * values[0] && values[3] > 0.1 * values[0]);
        let weak = v_t.row(4).dot(&other_v_t.row(4)).abs();
        assert!((weak - 1.0).abs() < ROUNDING);
    }
}
