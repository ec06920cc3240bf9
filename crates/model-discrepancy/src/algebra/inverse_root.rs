//! Inverse square roots as a sum of inverses.

use std::sync::OnceLock;

/// Smallest eigenvalue for which the sum holds; the largest is one.
pub(crate) const SMALLEST: f64 = 1e-4;

/// Terms of the sum: the error of the root falls by three digits with every six.
const TERMS: usize = 20;

/// Halvings of the distance of the two means: each doubles the digits.
const MEANS: usize = 8;
/// Two to the power of [`MEANS`].
const MEANS_DOUBLED: f64 = 256.0;

/// Weights `w` and shifts `τ` with `z^(−½) = Σ w/(z + τ)` for z from [`SMALLEST`] to one.
///
/// The midpoint rule on `2/π ∫ ds/(z + s²)`, with `s` the elliptic function sc: an analytic function
/// of period 2K, so that the error falls geometrically (Hale, Higham and Trefethen 2008, method 3).
pub(crate) fn terms() -> &'static [(f64, f64)] {
    static TERMS_FOUND: OnceLock<Vec<(f64, f64)>> = OnceLock::new();
    TERMS_FOUND.get_or_init(found)
}

#[expect(clippy::cast_precision_loss, reason = "counts are small")]
fn found() -> Vec<(f64, f64)> {
    // Arithmetic-geometric means, for the parameter 1 − SMALLEST.
    let mut means = vec![(1.0_f64, SMALLEST.sqrt())];
    for n in 0..MEANS {
        let (a, g) = means[n];
        means.push((f64::midpoint(a, g), (a * g).sqrt()));
    }
    let last = means[MEANS].0;
    let quarter = std::f64::consts::FRAC_PI_2 / last;
    let term = |j: usize| {
        let u = (j as f64 + 0.5) * quarter / TERMS as f64;
        let doublings = MEANS_DOUBLED;
        let mut amplitude = doublings * last * u;
        for pair in means.windows(2).rev() {
            let share = (pair[0].0 - pair[0].1) / 2.0 / pair[1].0;
            amplitude = f64::midpoint(amplitude, (share * amplitude.sin()).asin());
        }
        let (sine, cosine) = amplitude.sin_cos();
        let slope = (1.0 - (1.0 - SMALLEST) * sine * sine).sqrt() / (cosine * cosine);
        let weight = 2.0 * quarter * SMALLEST.sqrt() / (std::f64::consts::PI * TERMS as f64);
        (weight * slope, SMALLEST * (sine / cosine).powi(2))
    };
    (0..TERMS).map(term).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of sums of some twenty terms, the largest of which hold a cosine of 1e-3.
    const ROUND_OFF: f64 = 1e-12;

    #[test]
    fn the_sum_is_the_root() {
        for step in 0..=400 {
            let z = SMALLEST.powf(f64::from(step) / 400.0);
            let sum: f64 = terms().iter().map(|(weight, shift)| weight / (z + shift)).sum();
            assert!((sum * z.sqrt() - 1.0).abs() < ROUND_OFF, "{z}: {}", sum * z.sqrt() - 1.0);
        }
    }
}
