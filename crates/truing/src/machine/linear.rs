//! What some rows of a closed loop say of its columns on their own.

use model_discrepancy::{Closure, Layout, Role};
use nalgebra::DVector;

/// Singular values of whitened columns of length one, below which a direction is not seen.
const UNSEEN: f64 = 1e-7;

/// Solution about that of all rows.
pub(super) struct OnTheirOwn {
    /// By how much each column moves.
    pub(super) moved: DVector<f64>,
    /// Standard uncertainty of each; `None` of one that the rows do not determine.
    pub(super) std: Vec<Option<f64>>,
}

/// Least squares on some of the fitted rows, of a model that is linear about the closed loop.
pub(super) fn on_their_own(
    closure: &Closure,
    layout: &Layout,
    is_among: impl Fn(usize) -> bool,
) -> OnTheirOwn {
    let role = |row: usize| layout.groups[layout.observations[layout.rows[row].observation]].role;
    let rows: Vec<usize> =
        (0..layout.rows.len()).filter(|&r| is_among(r) && role(r) != Role::Check).collect();
    let sigma: Vec<f64> = rows.iter().map(|&row| layout.rows[row].sigma).collect();
    let mut jacobian = closure.jacobian.select_rows(&rows);
    let mut residual =
        DVector::from_iterator(rows.len(), rows.iter().map(|&row| closure.residuals_after[row]));
    for (k, sigma) in sigma.iter().enumerate() {
        jacobian.row_mut(k).unscale_mut(*sigma);
        residual[k] /= sigma;
    }
    let columns = jacobian.ncols();
    let lengths: Vec<f64> = jacobian.column_iter().map(|c| c.norm()).collect();
    for (mut column, length) in jacobian.column_iter_mut().zip(&lengths) {
        column.unscale_mut(length.max(f64::MIN_POSITIVE));
    }
    if rows.len() < columns {
        jacobian = jacobian.resize_vertically(columns, 0.0);
        residual = residual.resize_vertically(columns, 0.0);
    }
    let svd = jacobian.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
        return OnTheirOwn { moved: DVector::zeros(columns), std: vec![None; columns] };
    };
    let largest = svd.singular_values.max();
    let is_seen = |k: usize| svd.singular_values[k] > UNSEEN * largest;
    let mut moved = DVector::zeros(columns);
    let mut variance = vec![0.0; columns];
    let mut unseen = vec![0.0; columns];
    for k in 0..columns {
        let along = v_t.row(k);
        for column in 0..columns {
            let share = along[column];
            if is_seen(k) {
                let singular = svd.singular_values[k];
                moved[column] -= share * u.column(k).dot(&residual) / singular;
                variance[column] += (share / singular).powi(2);
            } else {
                unseen[column] += share * share;
            }
        }
    }
    let std = (0..columns)
        .map(|c| {
            let is_determined = lengths[c] > 0.0 && unseen[c] < UNSEEN;
            is_determined.then(|| (variance[c] * closure.variance_factor).sqrt() / lengths[c])
        })
        .collect();
    for (value, length) in moved.iter_mut().zip(&lengths) {
        *value /= length.max(f64::MIN_POSITIVE);
    }
    OnTheirOwn { moved, std }
}
