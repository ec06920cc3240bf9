//! Constant and harmonics of a planar signal, weighted by the load, at a given frequency.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, Matrix2, Vector2};

use crate::gate::InContact;

/// Gauss-Newton steps on the frequency; it converges quadratically from half a bin.
const MAX_STEPS: usize = 12;
/// Turns over the whole record below which the last step settles it: the next would be far less, and the centre goes with its
/// square.
const SETTLED: f64 = 1e-7;

/// Least-squares fit of `m = Fz (c + Σ aₕ cos hωt + bₕ sin hωt)`.
///
/// In this form every sample of a sensor with constant noise has the same weight; for the
/// centre it amounts to weights `Fz²`.
#[derive(Clone, Debug)]
pub(crate) struct HarmonicFit {
    /// `c`, then `a₁, b₁, a₂, b₂, …`; one column per axis.
    pub(crate) coefficients: DMatrix<f64>,
    /// `m − Fz·p`, N·mm.
    pub(crate) residuals_nmm: Vec<[f64; 2]>,
    /// Weight of each sample's `m` in `c`.
    pub(crate) influence: Vec<f64>,
}

/// Frequency and number of harmonics of a fit; no harmonics where there is no spin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Basis {
    pub(crate) frequency_hz: f64,
    pub(crate) harmonics: usize,
}

impl Basis {
    pub(crate) const CONSTANT: Self = Self { frequency_hz: 0.0, harmonics: 0 };

    pub(crate) fn columns(self) -> usize {
        1 + 2 * self.harmonics
    }
}

impl HarmonicFit {
    pub(crate) fn center_mm(&self) -> Vector2<f64> {
        Vector2::new(self.coefficients[(0, 0)], self.coefficients[(0, 1)])
    }

    /// `Σ u uᵀ` over samples, N²mm².
    pub(crate) fn residual_moments(&self) -> Matrix2<f64> {
        self.residuals_nmm.iter().fold(Matrix2::zeros(), |sum, u| {
            let u = Vector2::from(*u);
            sum + u * u.transpose()
        })
    }
}

/// Fits constant and harmonics; `None` where the samples do not tell the columns apart.
pub(crate) fn fit(samples: &[InContact], basis: Basis) -> Option<HarmonicFit> {
    fit_with_columns(samples, basis).map(|(fitted, _)| fitted)
}

/// Columns of a fit.
struct Columns {
    /// `Fz`, then `Fz cos hωt` and `Fz sin hωt` of each harmonic.
    design: DMatrix<f64>,
    /// An orthonormal basis of them.
    orthonormal: DMatrix<f64>,
}

/// The same with its columns.
fn fit_with_columns(samples: &[InContact], basis: Basis) -> Option<(HarmonicFit, Columns)> {
    let design = design(samples, basis);
    let moments = DMatrix::from_fn(samples.len(), 2, |i, axis| samples[i].moment_nmm[axis]);
    let qr = design.clone().qr();
    let (q, r) = (qr.q(), qr.r());
    let smallest = r.diagonal().abs().min();
    if smallest <= RANK_TOLERANCE * r.diagonal().abs().max() {
        return None;
    }
    let coefficients = r.solve_upper_triangular(&(q.transpose() * &moments))?;
    let left = &moments - &design * &coefficients;
    let residuals_nmm = left.row_iter().map(|row| [row[0], row[1]]).collect();
    // c = e₁ᵀ R⁻¹ Qᵀ m
    let mut first = DMatrix::zeros(basis.columns(), 1);
    first[(0, 0)] = 1.0;
    let weights = r.tr_solve_upper_triangular(&first)?;
    let influence = (&q * weights).iter().copied().collect();
    let fitted = HarmonicFit { coefficients, residuals_nmm, influence };
    Some((fitted, Columns { design, orthonormal: q }))
}

/// Ratio of diagonal entries of R under which a record does not tell a harmonic from a constant:
/// less than about a hundredth of a turn.
const RANK_TOLERANCE: f64 = 1e-3;

/// Moves the frequency to where the fit leaves least.
pub(crate) fn refine(samples: &[InContact], start: Basis) -> Option<(Basis, HarmonicFit)> {
    let length_s = samples[samples.len() - 1].time_s - samples[0].time_s;
    let most_hz = 0.25 / length_s;
    let mut basis = start;
    let (mut fitted, mut columns) = fit_with_columns(samples, basis)?;
    for _ in 0..MAX_STEPS {
        let step_hz = frequency_step(samples, basis, &fitted, &columns)?.clamp(-most_hz, most_hz);
        basis.frequency_hz += step_hz;
        (fitted, columns) = fit_with_columns(samples, basis)?;
        if (step_hz * length_s).abs() < SETTLED {
            break;
        }
    }
    Some((basis, fitted))
}

/// Gauss-Newton step: residual on the derivative by frequency, beside the other columns.
fn frequency_step(
    samples: &[InContact],
    basis: Basis,
    fitted: &HarmonicFit,
    Columns { design, orthonormal: q }: &Columns,
) -> Option<f64> {
    let mut slope = DMatrix::zeros(samples.len(), 2);
    let middle_s = middle(samples);
    for (i, s) in samples.iter().enumerate() {
        let t = s.time_s - middle_s;
        for h in 1..=basis.harmonics {
            let rate = TAU * crate::count(h) * t;
            let (cos, sin) = (design[(i, 2 * h - 1)], design[(i, 2 * h)]);
            for axis in 0..2 {
                let a = fitted.coefficients[(2 * h - 1, axis)];
                let b = fitted.coefficients[(2 * h, axis)];
                slope[(i, axis)] += rate * (b * cos - a * sin);
            }
        }
    }
    let slope = &slope - q * (q.transpose() * &slope);
    let along: f64 = (slope.row_iter().zip(&fitted.residuals_nmm))
        .map(|(row, u)| row[0] * u[0] + row[1] * u[1])
        .sum();
    let step = along / slope.norm_squared();
    step.is_finite().then_some(step)
}

/// Time about which harmonics turn, so that phase and frequency are little correlated.
pub(crate) fn middle(samples: &[InContact]) -> f64 {
    0.5 * (samples[0].time_s + samples[samples.len() - 1].time_s)
}

fn design(samples: &[InContact], basis: Basis) -> DMatrix<f64> {
    let mut design = DMatrix::zeros(samples.len(), basis.columns());
    let middle_s = middle(samples);
    for (i, s) in samples.iter().enumerate() {
        design[(i, 0)] = s.fz_n;
        let (sin, cos) = (TAU * basis.frequency_hz * (s.time_s - middle_s)).sin_cos();
        let (mut real, mut imaginary) = (s.fz_n, 0.0);
        for h in 1..=basis.harmonics {
            (real, imaginary) = (real * cos - imaginary * sin, real * sin + imaginary * cos);
            design[(i, 2 * h - 1)] = real;
            design[(i, 2 * h)] = imaginary;
        }
    }
    design
}
