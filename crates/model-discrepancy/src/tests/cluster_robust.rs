//! Wald test that asks no more than independent groups.

use nalgebra::{DMatrix, DMatrixView};

use crate::algebra::basis::Basis;
use crate::algebra::f_tail::f_tail;
use crate::algebra::leverage::{Adjusted, adjusted_by_rows};
use crate::algebra::product::{times, view};
use crate::count::count;
use crate::noise::linear::Linear;

/// Wald test of the amplitudes in the orthonormal basis `added`, the last columns of `full`, on their
/// CR2 covariance.
pub(crate) fn cluster_robust(lin: &Linear<'_>, added: &Basis, full: &Basis) -> f64 {
    let residual = full.reject(&lin.residual);
    let beside = full.columns_from(lin.basis.dim());
    let m = added.dim();
    let known = lin.noise.leverages(lin);
    // M_g = A_g·G_g and K_g = Q_gᵀ·M_g, with A_g = (I − Q_g·Q_gᵀ)^(−½).
    let adjust = |(g, cluster): (usize, &Vec<usize>)| {
        let by_terms = known[g].as_ref().and_then(|known| known.adjusted(&beside, m, &residual));
        by_terms
            .or_else(|| adjusted_by_rows(&full.rows(cluster), m, &residual.select_rows(cluster)))
    };
    let adjusted: Option<Vec<Adjusted>> = lin.clusters.iter().enumerate().map(adjust).collect();
    let Some(adjusted) = adjusted else { return 1.0 };
    let mut covariance = DMatrix::zeros(m, m);
    for one in &adjusted {
        covariance.ger(1.0, &one.score, &one.score, 1.0);
    }
    let amplitude = added.matrix().tr_mul(&lin.residual);
    let Some(cholesky) = covariance.cholesky() else { return 1.0 };
    let wald = amplitude.dot(&cholesky.solve(&amplitude));
    let eta = satterthwaite(&adjusted, m);
    let dof = eta - count(m) + 1.0;
    if dof <= 0.0 {
        return 1.0;
    }
    f_tail(wald * dof / (eta * count(m)), count(m), dof)
}

/// Degrees of freedom of the Wishart law that matches the total variance of CR2: of the products
/// `P` of all pairs of clusters, `(tr P)² + tr P²`, with `P = M_gᵀ·M_g − K_gᵀ·K_g` of a cluster with
/// itself, else `−K_gᵀ·K_h`.
fn satterthwaite(adjusted: &[Adjusted], m: usize) -> f64 {
    let columns = adjusted.first().map_or(0, |a| a.across.nrows());
    let shared = if 2 * columns < adjusted.len() {
        of_pairs_by_moments(adjusted, columns, m)
    } else {
        of_pairs(adjusted, m)
    };
    let own = adjusted.iter().map(|a| {
        let product = a.across.tr_mul(&a.across);
        squares((&a.square - &product).as_view()) - squares(product.as_view())
    });
    count(m * (m + 1)) / (shared + own.sum::<f64>())
}

/// `(tr P)² + tr P²`.
fn squares(product: DMatrixView<'_, f64>) -> f64 {
    let of_square = (0..product.nrows()).map(|i| product.row(i).tr_dot(&product.column(i)));
    product.trace().powi(2) + of_square.sum::<f64>()
}

/// Clusters whose products with the others are found together.
const TOGETHER: usize = 32;

/// Sum of [`squares`] of `K_gᵀ·K_h` over all pairs, pair by pair.
fn of_pairs(adjusted: &[Adjusted], m: usize) -> f64 {
    let columns: Vec<_> = adjusted.iter().flat_map(|a| a.across.column_iter()).collect();
    let all = DMatrix::from_columns(&columns);
    let mut total = 0.0;
    for start in (0..adjusted.len()).step_by(TOGETHER) {
        let end = (start + TOGETHER).min(adjusted.len());
        let some = view(&all).subcols(m * start, m * (end - start)).transpose();
        let products = times(some, view(&all).subcols(m * start, m * (adjusted.len() - start)));
        for g in start..end {
            for h in g..adjusted.len() {
                let product = products.view((m * (g - start), m * (h - start)), (m, m));
                let term = squares(product);
                // A pair and the same the other way round.
                total += if g == h { term } else { 2.0 * term };
            }
        }
    }
    total
}

/// The same by the second moments of the entries of `K`, `Σ_g K_ai·K_bj`: `Σ W²_(ai)(bj)` and
/// `Σ W_(ai)(bj)·W_(aj)(bi)`, for many clusters beside few columns.
fn of_pairs_by_moments(adjusted: &[Adjusted], columns: usize, m: usize) -> f64 {
    let entries = adjusted.iter().flat_map(|a| a.across.iter().copied());
    let all = DMatrix::from_iterator(columns * m, adjusted.len(), entries);
    let moments = times(view(&all), view(&all).transpose());
    let mut crossed = 0.0;
    for (i, j) in (0..m).flat_map(|i| (0..m).map(move |j| (i, j))) {
        let block = |i, j| moments.view((columns * i, columns * j), (columns, columns));
        // W_(aj)(bi) is the block of j and i.
        crossed += block(i, j).dot(&block(j, i));
    }
    moments.norm_squared() + crossed
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;

    /// Of sums over some thousand products.
    const ROUND_OFF: f64 = 1e-12;

    #[test]
    fn moments_give_what_all_pairs_give() {
        let wave = |of: usize| move |i: usize, j: usize| (0.7 * count(i * of + 3 * j * j)).sin();
        let cluster = |g: usize| Adjusted {
            square: DMatrix::from_fn(2, 2, wave(g + 5)),
            across: DMatrix::from_fn(4, 2, wave(2 * g + 1)),
            score: DVector::zeros(2),
        };
        let adjusted: Vec<Adjusted> = (0..9).map(cluster).collect();
        let by_hand: f64 = (adjusted.iter())
            .flat_map(|g| {
                adjusted.iter().map(move |h| squares(g.across.tr_mul(&h.across).as_view()))
            })
            .sum();
        assert!((of_pairs(&adjusted, 2) / by_hand - 1.0).abs() < ROUND_OFF);
        assert!((of_pairs_by_moments(&adjusted, 4, 2) / by_hand - 1.0).abs() < ROUND_OFF);
    }
}
