//! How large an effect must be to be found: the non-central F-test, for a known design.

use crate::generators::vector::{norm, orthogonalise};

/// Probability of a false addition that the whole catalogue shares.
const ALPHA: f64 = 0.05;
/// Probability with which an effect of the smallest size is found.
const POWER: f64 = 0.9;

/// What the test knows of an effect.
#[derive(Clone, Debug)]
pub(crate) struct Design {
    /// Displacement by the effect at size one over the standard uncertainty, row by row.
    pub signal: Vec<f64>,
    /// The same for one unit of every parameter of the declared model.
    pub base: Vec<Vec<f64>>,
    /// Amplitudes of the effect.
    pub n_amplitudes: usize,
    /// Effects that share the probability of a false addition.
    pub n_candidates: usize,
}

/// Factor by which the effect must be multiplied to be found nine times in ten.
///
/// The signal counts only as far as the declared model cannot absorb it; the level is shared
/// equally over the candidates.
pub(crate) fn smallest(design: &Design) -> f64 {
    let mut signal = design.signal.clone();
    orthogonalise(&mut signal, &design.base);
    let m = as_f64(design.n_amplitudes);
    let dof = as_f64(signal.len()) - as_f64(design.base.len()) - m;
    let level = ALPHA / as_f64(design.n_candidates);
    let critical = bisect(1e6, |f| level - (1.0 - f_cdf(f, m, dof, 0.0)));
    let noncentrality = bisect(1e4, |lambda| (1.0 - f_cdf(critical, m, dof, lambda)) - POWER);
    noncentrality.sqrt() / norm(&signal)
}

/// Where a rising function is zero, between 0 and `end`.
fn bisect(end: f64, rising: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, end);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if rising(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Distribution function of F with `m` and `dof` degrees of freedom and non-centrality `lambda`:
/// a Poisson mixture of incomplete beta functions.
fn f_cdf(f: f64, m: f64, dof: f64, lambda: f64) -> f64 {
    let x = m * f / (m * f + dof);
    let mean = lambda / 2.0;
    let n_terms = mean + 12.0 * mean.sqrt() + 12.0;
    let mut sum = 0.0;
    let mut j = 0.0;
    while j < n_terms {
        let log_weight = if mean > 0.0 {
            j * mean.ln() - mean - ln_gamma(j + 1.0)
        } else if j == 0.0 {
            0.0
        } else {
            break;
        };
        sum += log_weight.exp() * incomplete_beta(m / 2.0 + j, dof / 2.0, x);
        j += 1.0;
    }
    sum
}

/// Regularised incomplete beta function by its continued fraction (Abramowitz and Stegun 26.5.8,
/// evaluated by Lentz's method).
fn incomplete_beta(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(b, a, 1.0 - x);
    }
    let front =
        (ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * (1.0 - x).ln()).exp() / a;
    let mut c = 1.0;
    let mut d = 1.0 / (1.0 - (a + b) * x / (a + 1.0));
    let mut fraction = d;
    for step in 1..500 {
        let k = f64::from(step);
        let even = k * (b - k) * x / ((a + 2.0 * k - 1.0) * (a + 2.0 * k));
        let odd = -(a + k) * (a + b + k) * x / ((a + 2.0 * k) * (a + 2.0 * k + 1.0));
        for term in [even, odd] {
            d = 1.0 / (1.0 + term * d);
            c = 1.0 + term / c;
            fraction *= c * d;
        }
        if (c * d - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * fraction
}

/// Logarithm of the gamma function for positive arguments: Stirling's series after shifting the
/// argument beyond 10, where three terms leave 1e-10.
fn ln_gamma(x: f64) -> f64 {
    let mut shift = 0.0;
    let mut x = x;
    while x < 10.0 {
        shift -= x.ln();
        x += 1.0;
    }
    let series = 1.0 / (12.0 * x) - 1.0 / (360.0 * x.powi(3)) + 1.0 / (1260.0 * x.powi(5));
    shift + (x - 0.5) * x.ln() - x + 0.5 * std::f64::consts::TAU.ln() + series
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(count: usize) -> f64 {
    count as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables: F(0.95; 3, 20) = 3.0984, F(0.99; 1, 60) = 7.0771; at one degree of freedom and many
    /// others, F' with λ = 10.507 exceeds the 5 % point 3.8415 with probability 0.90 (the square
    /// of a unit normal shifted by 1.960 + 1.2816).
    #[test]
    fn quantiles_and_power_agree_with_tables() {
        assert!((f_cdf(3.0984, 3.0, 20.0, 0.0) - 0.95).abs() < 1e-5);
        assert!((f_cdf(7.0771, 1.0, 60.0, 0.0) - 0.99).abs() < 1e-5);
        assert!((1.0 - f_cdf(3.8415, 1.0, 1e7, 10.507) - 0.90).abs() < 2e-3);
    }

    #[test]
    fn what_the_base_absorbs_does_not_count() {
        let design = |signal: Vec<f64>| Design {
            signal,
            base: vec![vec![1.0; 40]],
            n_amplitudes: 1,
            n_candidates: 1,
        };
        let zigzag: Vec<f64> = (0..40).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let raised: Vec<f64> = zigzag.iter().map(|v| v + 7.0).collect();
        let (plain, offset) = (smallest(&design(zigzag)), smallest(&design(raised)));
        assert!((plain / offset - 1.0).abs() < 1e-9, "{plain} {offset}");
        // √(λ/n) with λ a little above 10.5, as 38 degrees of freedom are not infinite.
        assert!(plain > 0.51 && plain < 0.55, "{plain}");
    }
}
