//! A basis that has names.

use nalgebra::DMatrix;

/// A basis of the same directions in which each has as few components as elimination gives.
///
/// Gauss-Jordan on the columns of `basis` with complete pivoting: each column ends with a 1 where
/// the others have a 0. Singular vectors of equal singular values are arbitrary up to a rotation;
/// these have names. Columns beyond the number of rows stay as the elimination leaves them.
///
/// ```
/// use nalgebra::DMatrix;
///
/// let mixed = DMatrix::from_row_slice(3, 2, &[0.6, 0.8, 0.8, -0.6, 0.0, 0.0]);
/// let named = least_squares::sparse_basis(mixed);
/// let lone = |column: usize| named.column(column).iter().filter(|v| v.abs() > 1e-12).count();
/// assert_eq!((lone(0), lone(1)), (1, 1));
/// ```
#[must_use]
pub fn sparse_basis(mut basis: DMatrix<f64>) -> DMatrix<f64> {
    let mut pivoted = Vec::new();
    for k in 0..basis.ncols() {
        let free_rows = (0..basis.nrows()).filter(|row| !pivoted.contains(row));
        let largest = |row: usize| basis.row(row).columns_range(k..).amax();
        let Some(row) = free_rows.max_by(|&a, &b| largest(a).total_cmp(&largest(b))) else { break };
        let column = k + basis.row(row).columns_range(k..).iamax_full().1;
        basis.swap_columns(k, column);
        let pivot = basis[(row, k)];
        basis.column_mut(k).unscale_mut(pivot);
        let unit = basis.column(k).into_owned();
        for other in (0..basis.ncols()).filter(|&other| other != k) {
            let share = basis[(row, other)];
            basis.column_mut(other).axpy(-share, &unit, 1.0);
        }
        pivoted.push(row);
    }
    basis
}
