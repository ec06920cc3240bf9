//! Correlation of successive observations, the commonest colour of noise.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use crate::linear::Linear;
use crate::significance::count;

/// Largest correlation taken seriously; above, noise and drift are the same thing.
const MAX_PHI: f64 = 0.95;

/// Values of a colour's parameter that are compared, zero included: finer than any data set can
/// tell.
const STEPS: u32 = 20;

/// Largest memory: at one half the noise is 1/f and no longer stationary.
const MAX_MEMORY: f64 = 0.49;

/// Longest series for which a long memory is tried: its cost grows with the square of the length.
const MAX_LENGTH_FOR_MEMORY: usize = 512;

/// How successive observations depend on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Colour {
    /// Autoregression of first order: the correlation of neighbours.
    Neighbours(f64),
    /// Fractionally integrated noise (Hosking 1981) of memory `d`: a spectrum `f^(−2d)`, which an
    /// autoregression of first order takes for flat at low frequencies.
    Memory(f64),
}

impl Colour {
    /// The colour a little whiter and a little less white, with the step between their parameters
    /// in standard deviations of what `dof` degrees of freedom tell of it.
    ///
    /// A memory is known with variance `6/(π²n)` (Hosking 1981), a correlation `φ` of neighbours
    /// with `(1 − φ²)/n`.
    pub(crate) fn beside(self, dof: usize) -> ([Self; 2], f64) {
        const STEP: f64 = 0.05;
        let around = |at: f64, largest: f64| [(at - STEP).max(0.0), (at + STEP).min(largest)];
        let (of, [low, high], variance): (fn(f64) -> Self, _, _) = match self {
            Self::Neighbours(phi) => (Self::Neighbours, around(phi, MAX_PHI), 1.0 - phi * phi),
            Self::Memory(d) => (Self::Memory, around(d, MAX_MEMORY), 6.0 / (PI * PI)),
        };
        ([of(low), of(high)], (high - low) / (variance / count(dof)).sqrt())
    }

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

/// The colours of either kind that make the residual of a fit with orthonormal columns `q` most
/// likely; white is none.
///
/// Restricted likelihood (Patterson and Thompson 1971): unlike the plain lag-one correlation it
/// is not pulled towards zero by what the fit has taken out.
pub(crate) fn likely_colours(lin: &Linear<'_>, q: &DMatrix<f64>) -> Vec<Colour> {
    let grid =
        |largest: f64| (1..STEPS).map(move |i| largest * f64::from(i) / f64::from(STEPS - 1));
    let white = deviance(lin, q, Colour::Neighbours(0.0));
    let best = |colours: &mut dyn Iterator<Item = Colour>| {
        colours
            .map(|c| (c, deviance(lin, q, c)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|(_, deviance)| *deviance < white)
            .map(|(colour, _)| colour)
    };
    let longest = lin.series.iter().map(Vec::len).max().unwrap_or(0);
    let neighbours = best(&mut grid(MAX_PHI).map(Colour::Neighbours));
    let memory = if longest <= MAX_LENGTH_FOR_MEMORY {
        best(&mut grid(MAX_MEMORY).map(Colour::Memory))
    } else {
        None
    };
    neighbours.into_iter().chain(memory).collect()
}

/// Minus twice the restricted log likelihood, up to a constant.
fn deviance(lin: &Linear<'_>, q: &DMatrix<f64>, colour: Colour) -> f64 {
    let residual = DMatrix::from_columns(std::slice::from_ref(&lin.residual));
    let dof = count(lin.rows.len().saturating_sub(q.ncols()));
    let white = Whitening::new(lin, colour);
    let design = white.apply(lin, q).qr();
    let mut y = white.apply(lin, &residual);
    design.q_tr_mul(&mut y);
    let square = y.rows(q.ncols(), y.nrows() - q.ncols()).norm_squared();
    let r = design.r();
    let volume: f64 = (0..q.ncols()).map(|i| 2.0 * r[(i, i)].abs().ln()).sum();
    dof * square.ln() + volume + white.volume(lin)
}

/// Turns noise of one colour into white noise.
pub(crate) struct Whitening {
    predictions: Vec<(Vec<f64>, f64)>,
}

impl Whitening {
    pub(crate) fn new(lin: &Linear<'_>, colour: Colour) -> Self {
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
    pub(crate) fn apply(&self, lin: &Linear<'_>, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = columns.clone();
        for one in &lin.series {
            for (t, &row) in one.iter().enumerate() {
                let (weights, variance) = &self.predictions[t];
                let mut left = columns.row(row).into_owned();
                for (weight, &earlier) in weights.iter().zip(one[..t].iter().rev()) {
                    left -= columns.row(earlier) * *weight;
                }
                out.row_mut(row).copy_from(&(left / variance.sqrt()));
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
