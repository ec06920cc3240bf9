//! Residuals whose tails are cut: a reading far off is no structure.

use nalgebra::DVector;

/// Robust standard deviations beyond which a reading counts as one at them: tails are no structure.
const WITHIN: f64 = 3.0;
/// Median of a normal distribution's absolute values, in standard deviations.
const MEDIAN: f64 = 0.6745;

/// Residuals of which none is farther off than usual noise goes.
pub(crate) fn without_tails(residual: &DVector<f64>) -> DVector<f64> {
    let mut sizes: Vec<f64> = residual.iter().map(|r| r.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let most = WITHIN * sizes.get(sizes.len() / 2).copied().unwrap_or(0.0) / MEDIAN;
    residual.map(|r| r.clamp(-most, most))
}
