//! A model whose readings are moved.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal};

use super::{Declared, Inside, Model, Proposal, Row, State};

/// Share of a row's sigma by which readings move that have no resolution.
const HARDLY: f64 = 1e-6;

/// A model with an offset on each residual.
pub(crate) struct Moved<'a> {
    model: &'a dyn Model,
    offsets: DVector<f64>,
}

impl<'a> Moved<'a> {
    /// The residual of every row moved by its offset, in report units.
    pub(crate) fn by(model: &'a dyn Model, offsets: DVector<f64>) -> Self {
        Self { model, offsets }
    }

    /// Every reported residual moved by at most half of [`Declared::resolution`], evenly spread,
    /// each of the `times` otherwise.
    pub(crate) fn within_resolution(model: &'a dyn Model, times: usize) -> Self {
        let Declared { layout, resolution, .. } = model.declared();
        let offset = |(i, row): (usize, &Row)| {
            let share = evenly(times * layout.rows.len() + i);
            let step = resolution.max(HARDLY * row.sigma);
            if row.reported { step * (share - 0.5) } else { 0.0 }
        };
        let rows = layout.rows.iter().enumerate().map(offset);
        Self { model, offsets: DVector::from_iterator(layout.rows.len(), rows) }
    }
}

/// The `n`-th of a fixed sequence without visible order, evenly spread over 0 to 1 (`SplitMix64`:
/// Steele, Lea and Flood 2014, figure 16).
fn evenly(n: usize) -> f64 {
    const GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;
    let mut z = GAMMA.wrapping_mul(n as u64 + 1);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    let high = u32::try_from((z ^ (z >> 31)) >> 32).unwrap_or(u32::MAX);
    f64::from(high) / f64::from(u32::MAX)
}

/// The `n`-th of a fixed sequence of standard normal numbers without visible order.
pub(crate) fn normally(n: usize) -> f64 {
    // The ends of the interval are no normal numbers.
    Normal::standard().inverse_cdf(evenly(n).clamp(1e-9, 1.0 - 1e-9))
}

impl Model for Moved<'_> {
    fn declared(&self) -> &Declared {
        self.model.declared()
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        self.model.residuals(at) + &self.offsets
    }

    fn base_jacobian(&self, at: &State) -> DMatrix<f64> {
        self.model.base_jacobian(at)
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        self.model.tangent(at, effect)
    }

    fn inside(&self, at: &State) -> Option<Inside> {
        self.model.inside(at)
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        self.model.proposals()
    }
}

#[cfg(test)]
mod tests {
    use super::{evenly, normally};

    /// Of 10 000 even numbers the mean is within 4 · √(1/12) / 100 of one half, neighbours' products
    /// within 4/12/100 of uncorrelated.
    #[test]
    fn numbers_are_even_and_without_order() {
        let all: Vec<f64> = (0..10_000).map(evenly).collect();
        let mean = all.iter().sum::<f64>() / 1e4;
        assert!((mean - 0.5).abs() < 4.0 * (1.0_f64 / 12.0).sqrt() / 100.0, "{mean}");
        for lag in [1, 2, 7, 100] {
            let products = all.iter().zip(&all[lag..]).map(|(a, b)| (a - 0.5) * (b - 0.5));
            let covariance = products.sum::<f64>() / 1e4;
            assert!(covariance.abs() < 4.0 / 12.0 / 100.0, "{lag}: {covariance}");
        }
    }
    /// Of 10 000 standard normal numbers the mean is within 4/100 of zero, the variance within
    /// 4 · √2 / 100 of one.
    #[test]
    fn normal_numbers_have_mean_zero_and_variance_one() {
        let all: Vec<f64> = (0..10_000).map(normally).collect();
        let mean = all.iter().sum::<f64>() / 1e4;
        let variance = all.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / 1e4;
        assert!(mean.abs() < 0.04, "{mean}");
        assert!((variance - 1.0).abs() < 4.0 * 2.0_f64.sqrt() / 100.0, "{variance}");
    }
}
