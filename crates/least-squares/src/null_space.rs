//! Readable names for a null space.

use nalgebra::{DMatrix, DVector};

use crate::{FreeDirection, sparse_basis};

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
    let reduced = sparse_basis(null_space.clone());
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
