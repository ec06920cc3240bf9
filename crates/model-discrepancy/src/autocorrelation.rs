//! Correlation of successive observations, the commonest colour of noise.

use nalgebra::{DMatrix, DVector, DVectorView};

use crate::linear::Linear;
use crate::significance::{count, f_tail};
use crate::whiteness::groups_are_runs;

/// Largest correlation taken seriously; above, noise and drift are the same thing.
const MAX_PHI: f64 = 0.95;

/// Values of a colour's parameter that are compared, zero included: finer than any data set can
/// tell.
const STEPS: u32 = 20;

/// Largest memory: at one half the noise is 1/f and no longer stationary.
const MAX_MEMORY: f64 = 0.45;

/// Longest series for which a long memory is tried: its cost grows with the square of the length.
const MAX_LENGTH_FOR_MEMORY: usize = 512;

/// How successive observations depend on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Colour {
    /// Autoregression of first order: the correlation of neighbours.
    Neighbours(f64),
    /// Fractionally integrated noise (Hosking 1981) of memory `d`: a spectrum `f^(−2d)`, which an
    /// autoregression of first order takes for flat at low frequencies.
    Memory(f64),
}

impl Colour {
    /// Prediction of each value from those before it, with the variance of its error.
    fn predictions(self, length: usize) -> Vec<(Vec<f64>, f64)> {
        match self {
            Self::Neighbours(phi) => (0..length)
                .map(|t| if t == 0 { (vec![], 1.0 / (1.0 - phi * phi)) } else { (vec![phi], 1.0) })
                .collect(),
            Self::Memory(d) => {
                // Durbin and Levinson's recursion on the partial correlations d/(k − d).
                let mut found: Vec<(Vec<f64>, f64)> = vec![(vec![], 1.0)];
                for k in 1..length {
                    let (before, variance) = &found[k - 1];
                    let partial = d / (count(k) - d);
                    let mut weights: Vec<_> =
                        (0..k - 1).map(|j| before[j] - partial * before[k - 2 - j]).collect();
                    weights.push(partial);
                    let variance = variance * (1.0 - partial * partial);
                    found.push((weights, variance));
                }
                found
            }
        }
    }
}

/// Colours less likely than this, beside the likeliest, are left out.
const NEGLIGIBLE: f64 = 1e-4;

/// p-values of the last `n_tested` of the orthonormal columns `q` with coloured noise along the
/// measured order, of which white is not the likeliest: for neighbours, and for long memory.
///
/// `residual` is what the columns before them leave of the data. The colour is not known, and the
/// variance of a slow effect depends on it: the p-value is the mean over the colours, each as
/// likely as the data make it. Restricted likelihood (Patterson and Thompson 1971): unlike the
/// plain lag-one correlation it is not pulled towards zero by what the fit has taken out. Where
/// groups are runs of readings a long memory is not tried: from the readings of a run it would
/// tell how far runs agree, which the scatter between runs tells better.
pub(crate) fn coloured_p_values(
    lin: &Linear<'_>,
    q: &DMatrix<f64>,
    n_tested: usize,
    residual: &DVector<f64>,
) -> Vec<f64> {
    let likelihood = Likelihood::new(lin, q, n_tested, residual);
    let mean = |largest: f64, of: fn(f64) -> Colour| -> Option<f64> {
        let grid = (0..STEPS).map(|i| of(largest * f64::from(i) / f64::from(STEPS - 1)));
        let judged: Vec<Coloured> = grid.filter_map(|c| likelihood.judge(c)).collect();
        let best = judged.iter().map(|c| c.deviance).fold(f64::INFINITY, f64::min);
        // White is the first of the grid.
        judged.first().filter(|white| white.deviance > best)?;
        let shares = judged.iter().map(|c| ((0.5 * (best - c.deviance)).exp(), c.p_value));
        let likely: Vec<_> = shares.filter(|(share, _)| *share > NEGLIGIBLE).collect();
        let sum: f64 = likely.iter().map(|(share, _)| share).sum();
        Some(likely.iter().map(|(share, p_value)| share * p_value).sum::<f64>() / sum)
    };
    let longest = lin.series.iter().map(Vec::len).max().unwrap_or(0);
    let neighbours = mean(MAX_PHI, Colour::Neighbours);
    let memory = if longest <= MAX_LENGTH_FOR_MEMORY && !groups_are_runs(lin) {
        mean(MAX_MEMORY, Colour::Memory)
    } else {
        None
    };
    neighbours.into_iter().chain(memory).collect()
}

/// The data under one colour of the noise.
struct Coloured {
    /// Minus twice the restricted log likelihood, up to a constant.
    deviance: f64,
    /// Of the F test of what is tested.
    p_value: f64,
}

/// Restricted likelihood of the colours of the noise beside one design.
struct Likelihood<'a> {
    lin: &'a Linear<'a>,
    /// Columns of the design, and what they leave of the data.
    columns: DMatrix<f64>,
    /// Shares in the data of the last columns of the design, which are tested.
    tested: DVector<f64>,
    /// Products of the columns after whitening with a correlation `φ` of neighbours: coefficients
    /// of 1, `−φ` and `φ²`.
    products: [DMatrix<f64>; 3],
}

impl<'a> Likelihood<'a> {
    fn new(
        lin: &'a Linear<'a>,
        q: &DMatrix<f64>,
        n_tested: usize,
        residual: &DVector<f64>,
    ) -> Self {
        let along = q.tr_mul(residual);
        let mut columns = q.clone().insert_column(q.ncols(), 0.0);
        // Without what the columns explain, so that no digits are lost in the products.
        columns.set_column(q.ncols(), &(residual - q * &along));
        let products = lagged_products(lin, &columns);
        let tested = along.rows(q.ncols() - n_tested, n_tested).into_owned();
        Self { lin, columns, tested, products }
    }

    /// One factorisation of the products gives the likelihood and the F test.
    fn judge(&self, colour: Colour) -> Option<Coloured> {
        let (products, of_noise) = if let Colour::Neighbours(phi) = colour {
            let [plain, lagged, inner] = &self.products;
            let volume = -count(self.lin.series.len()) * (1.0 - phi * phi).ln();
            (plain - lagged * phi + inner * (phi * phi), volume)
        } else {
            let white = Whitening::new(self.lin, colour);
            let columns = white.apply(self.lin, &self.columns);
            (columns.transpose() * &columns, white.volume(self.lin))
        };
        let (n, m) = (self.columns.ncols() - 1, self.tested.len());
        let dof = count(self.lin.rows.len().saturating_sub(n));
        let factor = products.cholesky()?.unpack();
        let square = factor[(n, n)].powi(2);
        let volume: f64 = (0..n).map(|i| 2.0 * factor[(i, i)].ln()).sum();
        // The row of the data, with what the tested columns explained put back.
        let own = factor.view((n - m, n - m), (m, m)).tr_mul(&self.tested);
        let explained = (own + factor.view((n, n - m), (1, m)).transpose()).norm_squared();
        let p_value = f_tail(explained / count(m) / (square / dof), count(m), dof);
        Some(Coloured { deviance: dof * square.ln() + volume + of_noise, p_value })
    }
}

/// Products of columns prewhitened as Prais and Winsten (1954) do, a polynomial of the second
/// degree in the correlation.
fn lagged_products(lin: &Linear<'_>, columns: &DMatrix<f64>) -> [DMatrix<f64>; 3] {
    let mut previous = DMatrix::zeros(columns.nrows(), columns.ncols());
    let firsts: Vec<_> = lin.series.iter().filter_map(|one| one.first().copied()).collect();
    for (mut to, from) in previous.column_iter_mut().zip(columns.column_iter()) {
        for pair in lin.series.iter().flat_map(|one| one.windows(2)) {
            to[pair[1]] = from[pair[0]];
        }
    }
    let first = columns.select_rows(&firsts);
    let across = columns.transpose() * &previous;
    let inner = previous.transpose() * &previous - first.tr_mul(&first);
    [columns.transpose() * columns, &across + across.transpose(), inner]
}

/// Turns noise of one colour into white noise.
struct Whitening {
    predictions: Vec<(Vec<f64>, f64)>,
}

impl Whitening {
    fn new(lin: &Linear<'_>, colour: Colour) -> Self {
        let longest = lin.series.iter().map(Vec::len).max().unwrap_or(0);
        Self { predictions: colour.predictions(longest) }
    }

    /// Logarithm of the determinant of the noise's covariance.
    fn volume(&self, lin: &Linear<'_>) -> f64 {
        let of =
            |one: &Vec<usize>| self.predictions[..one.len()].iter().map(|p| p.1.ln()).sum::<f64>();
        lin.series.iter().map(of).sum()
    }

    /// Rows less what their predecessors predict, each to the same variance; rows outside any
    /// series stay as they are.
    fn apply(&self, lin: &Linear<'_>, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = columns.clone();
        let mut values = Vec::new();
        for (mut to, from) in out.column_iter_mut().zip(columns.column_iter()) {
            for one in &lin.series {
                // The latest first, as the weights are.
                values.clear();
                values.extend(one.iter().rev().map(|&row| from[row]));
                for (t, &row) in one.iter().enumerate() {
                    let (weights, variance) = &self.predictions[t];
                    let earlier = &values[one.len() - t..];
                    let weights = DVectorView::from_slice(weights, weights.len());
                    let earlier = DVectorView::from_slice(earlier, weights.len());
                    let predicted = weights.dot(&earlier);
                    to[row] = (from[row] - predicted) / variance.sqrt();
                }
            }
        }
        out
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
