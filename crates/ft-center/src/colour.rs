//! Covariance of a mean under coloured noise.

use std::f64::consts::PI;

use nalgebra::{Matrix2, Vector2};

/// Blocks at whose scale the colour of the noise is judged.
const BLOCKS: usize = 128;

/// Most cosines averaged: their number is the degrees of freedom of the answer.
const MAX_COSINES: usize = 32;

/// Fewest cosines averaged, however coloured the noise.
const MIN_COSINES: usize = 4;

/// Share by which the spectrum may have fallen, on average over the cosines used.
const MAX_FALL: f64 = 0.1;

/// Largest correlation of neighbouring blocks that is believed: noise that remembers a quarter
/// of the record.
const MAX_CORRELATION: f64 = 0.97;

/// Covariance of a mean with the degrees of freedom it is known to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeanCovariance {
    pub(crate) covariance: Matrix2<f64>,
    pub(crate) degrees_of_freedom: f64,
}

/// Covariance of the mean of `values`, whose own mean is zero, in measured order.
///
/// The spectral density at frequency zero is the mean square of the first few cosine
/// coefficients (equal-weighted cosines: Lazarus, Lewis, Stock and Watson 2018), as many as the
/// spectrum is flat over. A first-order autoregression of block means tells how many, and by how
/// much each has fallen from frequency zero (recolouring: Andrews and Monahan 1992). `lines`
/// are numbers of turns in the record that a fit has removed; cosines beside them are left out.
pub(crate) fn mean_covariance(values: &[Vector2<f64>], lines: &[f64]) -> MeanCovariance {
    let n = values.len();
    let colour = Colour::of(values);
    let wanted = colour.cosines().min(n / 2).max(1);
    // Cosine j makes j/2 turns; a removed line leaves a notch of about one turn.
    let beside =
        |j: &usize| lines.iter().all(|turns| (crate::count(*j) - 2.0 * turns).abs() >= 1.5);
    let mut sum = Matrix2::zeros();
    let mut used = 0;
    for j in (1..n.max(2)).filter(beside).take(wanted) {
        let c = cosine_coefficient(values, j);
        sum += c * c.transpose() / colour.power_ratio(j);
        used += 1;
    }
    let used = crate::count(used.max(1));
    MeanCovariance { covariance: sum / (used * crate::count(n)), degrees_of_freedom: used }
}

/// `√(2/n) Σ v cos(πj(i + ½)/n)`, by the rotation recurrence.
fn cosine_coefficient(values: &[Vector2<f64>], j: usize) -> Vector2<f64> {
    let n = crate::count(values.len());
    let step = PI * crate::count(j) / n;
    let (sin_step, cos_step) = step.sin_cos();
    let (mut sin, mut cos) = (0.5 * step).sin_cos();
    let mut sum = Vector2::zeros();
    for v in values {
        sum += v * cos;
        (sin, cos) = (sin * cos_step + cos * sin_step, cos * cos_step - sin * sin_step);
    }
    sum * (2.0 / n).sqrt()
}

/// A first-order autoregression of block means.
#[derive(Clone, Copy, Debug)]
struct Colour {
    blocks: f64,
    /// Correlation of neighbouring blocks, 0 to [`MAX_CORRELATION`].
    correlation: f64,
}

impl Colour {
    fn of(values: &[Vector2<f64>]) -> Self {
        let blocks = block_means(values);
        let correlation = lag_one(&blocks).clamp(0.0, MAX_CORRELATION);
        Self { blocks: crate::count(blocks.len()), correlation }
    }

    /// Cosines over which the spectrum falls by [`MAX_FALL`] on average, which for `B` of them
    /// is `ρ π² B² / (3 K² (1 − ρ)²)`.
    fn cosines(self) -> usize {
        let rho = self.correlation.max(1e-6);
        let most = self.blocks * (1.0 - rho) / PI * (3.0 * MAX_FALL / rho).sqrt();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive and limited before the cast"
        )]
        let most = most.min(crate::count(MAX_COSINES)) as usize;
        most.max(MIN_COSINES)
    }

    /// Spectral density at cosine `j` over that at frequency zero.
    fn power_ratio(self, j: usize) -> f64 {
        let rho = self.correlation;
        let angle = PI * crate::count(j) / self.blocks;
        (1.0 - rho).powi(2) / (1.0 - 2.0 * rho * angle.cos() + rho * rho)
    }
}

fn block_means(values: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
    let size = values.len().div_ceil(BLOCKS).max(1);
    values.chunks(size).map(|c| c.iter().sum::<Vector2<f64>>() / crate::count(c.len())).collect()
}

/// Lag-one correlation of the more correlated axis, freed of its bias `−(1 + 3ρ)/K`.
fn lag_one(blocks: &[Vector2<f64>]) -> f64 {
    let k = crate::count(blocks.len());
    let axis = |a: usize| {
        let mean = blocks.iter().map(|b| b[a]).sum::<f64>() / k;
        let square: f64 = blocks.iter().map(|b| (b[a] - mean).powi(2)).sum();
        let cross: f64 = blocks.windows(2).map(|w| (w[0][a] - mean) * (w[1][a] - mean)).sum();
        let rho = if square > 0.0 { cross / square } else { 0.0 };
        (rho + 1.0 / k) / (1.0 - 3.0 / k).max(0.1)
    };
    axis(0).max(axis(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step between two halves of `n` values: `n − 3` of `n − 1` neighbours agree, one pair does not, so
    /// that the plain correlation is `(n − 3)/n`.
    #[test]
    fn a_correlation_is_freed_of_its_bias() {
        // Powers of two: every operation but the last is exact.
        for n in [8_i32, 16, 64] {
            let halves: Vec<_> =
                (0..n).map(|i| Vector2::new(if 2 * i < n { 1.0 } else { -1.0 }, 0.0)).collect();
            let k = f64::from(n);
            // E r = ρ − (1 + 3ρ)/K, solved for ρ at r = 1 − 3/K.
            let freed = (1.0 - 2.0 / k) / (1.0 - 3.0 / k);
            assert!((lag_one(&halves) - freed).abs() <= f64::EPSILON * freed, "{n}");
        }
    }
}
