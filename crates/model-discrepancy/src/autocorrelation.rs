//! Correlation of successive observations, the commonest colour of noise.

use nalgebra::{DMatrix, DVector};

use crate::linear::Linear;

/// Largest correlation taken seriously; above, noise and drift are the same thing.
const MAX_PHI: f64 = 0.97;

/// Lag-one correlation along the measured order, pooled over components.
///
/// Corrected for the correlation that a fit with orthonormal columns `q` puts into white noise:
/// `E[eₜ·eₜ₋₁] = −s²·hₜ,ₜ₋₁`.
pub(crate) fn lag_one(lin: &Linear<'_>, q: &DMatrix<f64>, residual: &DVector<f64>) -> f64 {
    let (raw, expected, _) = lag_one_terms(lin, q, residual);
    (raw - expected).clamp(-MAX_PHI, MAX_PHI)
}

/// Significance of the lag-one correlation (normal approximation, one-sided for `φ > 0`).
pub(crate) fn lag_one_z(lin: &Linear<'_>, q: &DMatrix<f64>, residual: &DVector<f64>) -> f64 {
    let (raw, expected, pairs) = lag_one_terms(lin, q, residual);
    (raw - expected) * pairs.sqrt()
}

fn lag_one_terms(lin: &Linear<'_>, q: &DMatrix<f64>, residual: &DVector<f64>) -> (f64, f64, f64) {
    let (mut lagged, mut square, mut leaked, mut free, mut pairs) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for one in &lin.series {
        for &i in one {
            square += residual[i] * residual[i];
            free += 1.0 - q.row(i).norm_squared();
        }
        for pair in one.windows(2) {
            lagged += residual[pair[0]] * residual[pair[1]];
            leaked -= q.row(pair[0]).dot(&q.row(pair[1]));
            pairs += 1.0;
        }
    }
    if square <= 0.0 || free <= 0.0 {
        return (0.0, 0.0, pairs);
    }
    (lagged / square, leaked / free, pairs)
}

/// Rows minus `phi` times their predecessor: white if the noise is AR(1).
///
/// The first row of a series is scaled to the same variance (Prais and Winsten 1954); rows
/// outside any series stay as they are.
pub(crate) fn prewhitened(lin: &Linear<'_>, columns: &DMatrix<f64>, phi: f64) -> DMatrix<f64> {
    let mut out = columns.clone();
    for one in &lin.series {
        if let Some(&first) = one.first() {
            out.row_mut(first).scale_mut((1.0 - phi * phi).sqrt());
        }
        for pair in one.windows(2) {
            let step = columns.row(pair[1]) - columns.row(pair[0]) * phi;
            out.row_mut(pair[1]).copy_from(&step);
        }
    }
    out
}
