//! Correlation of successive observations, the commonest colour of noise.

use nalgebra::{DMatrix, DVector};

use crate::linear::Linear;
use crate::significance::count;

/// Largest correlation taken seriously; above, noise and drift are the same thing.
const MAX_PHI: f64 = 0.95;

/// Values of the correlation that are compared: 0.05 apart, finer than any data set can tell.
const PHI_STEPS: u32 = 20;

/// Correlation of successive observations that makes the residual of a fit with orthonormal
/// columns `q` most likely, 0 to 0.95.
///
/// Restricted likelihood (Patterson and Thompson 1971): unlike the plain lag-one correlation it
/// is not pulled towards zero by what the fit has taken out.
pub(crate) fn restricted_likelihood_phi(lin: &Linear<'_>, q: &DMatrix<f64>) -> f64 {
    let residual = DMatrix::from_columns(std::slice::from_ref(&lin.residual));
    let dof = count(lin.rows.len().saturating_sub(q.ncols()));
    let n_series = count(lin.series.len());
    let deviance = |phi: f64| {
        let design = prewhitened(lin, q, phi).qr();
        let mut y = prewhitened(lin, &residual, phi);
        design.q_tr_mul(&mut y);
        let square = y.rows(q.ncols(), y.nrows() - q.ncols()).norm_squared();
        let r = design.r();
        let volume: f64 = (0..q.ncols()).map(|i| 2.0 * r[(i, i)].abs().ln()).sum();
        dof * square.ln() + volume - n_series * (1.0 - phi * phi).ln()
    };
    let grid = (0..PHI_STEPS).map(|i| MAX_PHI * f64::from(i) / f64::from(PHI_STEPS - 1));
    grid.map(|phi| (phi, deviance(phi)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map_or(0.0, |(phi, _)| phi)
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
