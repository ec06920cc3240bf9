//! Readable names for a null space.

use nalgebra::{DMatrix, DVector};

use crate::FreeDirection;

/// Shares below this, of a largest share of 1, are left out of a name.
const MIN_SHARE: f64 = 0.05;
/// Most components a name lists.
const MAX_COMPONENTS: usize = 6;

/// One direction per column of `null_space`, rewritten so that each has as few components as
/// elimination gives: the basis itself is arbitrary up to a rotation.
pub(crate) fn free_directions(
    null_space: &DMatrix<f64>,
    scale: &DVector<f64>,
    free: &[usize],
    tangent_dim: usize,
    name: impl Fn(usize) -> String,
) -> Vec<FreeDirection> {
    let reduced = eliminate(null_space.clone());
    reduced
        .column_iter()
        .map(|column| {
            let mut by_share: Vec<usize> = (0..column.len()).collect();
            by_share.sort_by(|&a, &b| column[b].abs().total_cmp(&column[a].abs()));
            let largest = column[by_share[0]];
            let components = by_share
                .iter()
                .map(|&i| (i, column[i] / largest))
                .filter(|(_, share)| share.abs() >= MIN_SHARE)
                .take(MAX_COMPONENTS)
                .map(|(i, share)| (name(free[i]), share))
                .collect();
            let mut step = DVector::zeros(tangent_dim);
            for (i, &index) in free.iter().enumerate() {
                step[index] = column[i] / (largest * scale[i]);
            }
            FreeDirection { components, step }
        })
        .collect()
}

/// Gauss-Jordan on columns with complete pivoting: each column ends with a 1 where the others
/// have a 0.
fn eliminate(mut basis: DMatrix<f64>) -> DMatrix<f64> {
    let mut pivoted = Vec::new();
    for k in 0..basis.ncols() {
        let row = (0..basis.nrows())
            .filter(|row| !pivoted.contains(row))
            .max_by(|&a, &b| {
                let largest = |row| basis.row(row).columns_range(k..).amax();
                largest(a).total_cmp(&largest(b))
            })
            .expect("a null space has no more columns than rows");
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
