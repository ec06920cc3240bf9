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
    let mut columns = q.clone().insert_column(q.ncols(), 0.0);
    // Without what the columns explain, so that no digits are lost in the products.
    let residual = &lin.residual - q * q.tr_mul(&lin.residual);
    columns.set_column(q.ncols(), &residual);
    let products = Products::of(lin, &columns);
    let dof = count(lin.rows.len().saturating_sub(q.ncols()));
    let n_series = count(lin.series.len());
    let deviance = |phi: f64| {
        let factor = products.at(phi).cholesky()?;
        let diagonal = factor.l_dirty().diagonal();
        let (square, volume) = (diagonal[q.ncols()].powi(2), diagonal.rows(0, q.ncols()));
        let volume: f64 = volume.iter().map(|d| 2.0 * d.ln()).sum();
        Some(dof * square.ln() + volume - n_series * (1.0 - phi * phi).ln())
    };
    let grid = (0..PHI_STEPS).map(|i| MAX_PHI * f64::from(i) / f64::from(PHI_STEPS - 1));
    grid.filter_map(|phi| deviance(phi).map(|d| (phi, d)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map_or(0.0, |(phi, _)| phi)
}

/// Products of prewhitened columns, a polynomial of the second degree in the correlation.
struct Products {
    plain: DMatrix<f64>,
    lagged: DMatrix<f64>,
    inner: DMatrix<f64>,
}

impl Products {
    fn of(lin: &Linear<'_>, columns: &DMatrix<f64>) -> Self {
        let mut previous = DMatrix::zeros(columns.nrows(), columns.ncols());
        let firsts: Vec<_> = lin.series.iter().filter_map(|one| one.first().copied()).collect();
        for (mut to, from) in previous.column_iter_mut().zip(columns.column_iter()) {
            for pair in lin.series.iter().flat_map(|one| one.windows(2)) {
                to[pair[1]] = from[pair[0]];
            }
        }
        let first = columns.select_rows(&firsts);
        let across = columns.tr_mul(&previous);
        Self {
            plain: columns.tr_mul(columns),
            lagged: &across + across.transpose(),
            inner: previous.tr_mul(&previous) - first.tr_mul(&first),
        }
    }

    fn at(&self, phi: f64) -> DMatrix<f64> {
        &self.plain - &self.lagged * phi + &self.inner * (phi * phi)
    }
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
    let first_scale = (1.0 - phi * phi).sqrt();
    for (mut to, from) in out.column_iter_mut().zip(columns.column_iter()) {
        for one in &lin.series {
            if let Some(&first) = one.first() {
                to[first] *= first_scale;
            }
            for pair in one.windows(2) {
                to[pair[1]] = from[pair[1]] - from[pair[0]] * phi;
            }
        }
    }
    out
}
