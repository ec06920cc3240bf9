//! Whether the data scatter as declared: the global test of the model.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::Role;
use crate::algebra::system::{Estimate, System};
use crate::count::count;
use crate::levels::CHI2_OUTSIDE;
use crate::noise::linear::Linear;
use crate::tests::tails::share_beside_tails;

/// Halvings of a bracket that leave nothing but round-off.
const HALVINGS: usize = 80;

/// Largest correlation of successive readings that is taken for memory; above, noise and drift are
/// the same thing.
const MAX_CORRELATION: f64 = 0.95;

/// Standard errors from which on a lag-one correlation is memory and not chance.
const CLEAR: f64 = 2.0;

/// χ² over degrees of freedom from which on no tails are asked for: an error of three times the noise is none of
/// these, however few data there are.
const NO_TAILS: f64 = 9.0;

/// χ² of the residual with the declared standard uncertainties.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlobalTest {
    /// Sum of the squares of residuals over their declared standard uncertainties.
    pub chi2: f64,
    /// Equations minus parameters.
    pub dof: f64,
    /// Share of the degrees of freedom that are independent of each other, above 0 and at most 1:
    /// noise with memory, or with heavy tails, has the same variance, which is known less well.
    pub share: f64,
}

impl GlobalTest {
    /// χ² over degrees of freedom: near one where the noise is as declared.
    #[must_use]
    pub fn per_dof(&self) -> f64 {
        self.chi2 / self.dof
    }

    /// Where [`GlobalTest::per_dof`] lies 999 times in 1000 where the noise is as declared.
    #[must_use]
    pub fn interval(&self) -> [f64; 2] {
        chi2_interval(self.dof * self.share)
    }

    /// Probability of as much where the noise is as declared.
    pub(crate) fn p_value(&self) -> f64 {
        let law = ChiSquared::new(self.dof * self.share);
        law.map_or(0.0, |law| law.sf(self.chi2 * self.share))
    }

    /// Whether the data scatter more than declared.
    #[must_use]
    pub fn is_above(&self) -> bool {
        self.per_dof() > self.interval()[1]
    }
}

/// Interval of χ² over degrees of freedom that holds 99.9 % where the noise is as declared, half
/// of the rest on each side.
///
/// `dof` may be a fraction: that of noise with memory.
#[must_use]
pub fn chi2_interval(dof: f64) -> [f64; 2] {
    let Ok(law) = ChiSquared::new(dof) else { return [0.0, f64::INFINITY] };
    // Beyond twenty standard deviations, and far beyond any quantile for small `dof`.
    let most = dof + 20.0 * (2.0 * dof).sqrt() + 100.0;
    let solve = |is_below: &dyn Fn(f64) -> bool| {
        let (mut low, mut high) = (0.0, most);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if is_below(middle) { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    };
    let low = solve(&|x| law.cdf(x) < 0.5 * CHI2_OUTSIDE);
    let high = solve(&|x| law.sf(x) > 0.5 * CHI2_OUTSIDE);
    [low / dof, high / dof]
}

/// Share of a series' squares that are independent of each other, from the correlation of
/// successive values and how many pairs of them there are.
///
/// `1/(1 + 2Σφ²ᵏ) = (1 − φ²)/(1 + φ²)` for noise of which neighbours agree by `φ` (Bartlett 1946);
/// one where the agreement may be chance.
#[must_use]
pub fn independent_share(correlation: f64, samples: f64) -> f64 {
    let is_clear = correlation * samples.sqrt() > CLEAR;
    let phi = if is_clear { correlation.min(MAX_CORRELATION) } else { 0.0 };
    (1.0 - phi * phi) / (1.0 + phi * phi)
}

/// Correlation of successive values of several series with mean zero, and how many pairs there
/// are.
#[must_use]
pub fn lag_one<'a>(series: impl Iterator<Item = &'a [f64]>) -> (f64, f64) {
    let (mut lagged, mut square, mut pairs) = (0.0, 0.0, 0.0);
    for one in series {
        square += one.iter().map(|v| v * v).sum::<f64>();
        lagged += one.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
        pairs += count(one.len().saturating_sub(1));
    }
    (if square > 0.0 { lagged / square } else { 0.0 }, pairs)
}

/// The global test of a fitted system; `None` where sigma was not declared, or nothing is
/// redundant.
///
/// Judged by what was declared, without any scatter that the loop has estimated; where rows are
/// means of readings, by the readings.
pub(crate) fn global_test(
    system: &System<'_>,
    at: &Estimate,
    lin: &Linear<'_>,
) -> Option<GlobalTest> {
    if !lin.layout.sigma_declared {
        return None;
    }
    let of_row = |i: usize| lin.residual[i] * lin.sigma[i] / lin.layout.rows[lin.rows[i]].sigma;
    let whitened: Vec<f64> = (0..lin.rows.len()).map(of_row).collect();
    let free = count(lin.rows.len()) - count(system.dim());
    let chi2: f64 = whitened.iter().map(|r| r * r).sum();
    let is_fitted = |&i: &usize| {
        let observation = lin.layout.rows[lin.rows[i]].observation;
        lin.layout.groups[lin.layout.observations[observation]].role == Role::Fit
    };
    let of_series = |one: &Vec<usize>| -> Vec<f64> {
        one.iter().filter(|i| is_fitted(i)).map(|&i| whitened[i]).collect()
    };
    let series: Vec<Vec<f64>> = lin.series.iter().map(of_series).collect();
    let (correlation, pairs) = lag_one(series.iter().map(Vec::as_slice));
    let share = independent_share(correlation, pairs);
    let mut test = GlobalTest { chi2, dof: free, share };
    if let Some(inside) = system.model.inside(&at.state).filter(|inside| inside.dof > 0.0) {
        test.chi2 += inside.chi2;
        test.dof += inside.dof;
        test.share = test.share.min(inside.share);
    }
    if test.is_above() && test.per_dof() < NO_TAILS {
        test.share *= share_beside_tails(lin);
    }
    (test.dof > 0.0).then_some(test)
}

#[cfg(test)]
mod tests {
    use super::{chi2_interval, independent_share, lag_one};

    /// Digits of the tables of χ² from which the quantiles are.
    const TABLE: f64 = 1e-3;

    #[test]
    fn interval_is_that_of_the_tables() {
        // Quantiles 0.0005 and 0.9995 of χ² with 1, 10 and 100 degrees of freedom.
        for (dof, low, high) in
            [(1.0, 3.93e-7, 12.116), (10.0, 1.265, 31.420), (100.0, 59.896, 153.167)]
        {
            let [found_low, found_high] = chi2_interval(dof);
            assert!((found_low * dof - low).abs() < TABLE * low.max(1.0), "{dof} {found_low}");
            assert!((found_high * dof - high).abs() < TABLE * high, "{dof} {found_high}");
        }
    }

    #[test]
    fn interval_of_many_readings_is_narrow_and_finite() {
        let [low, high] = chi2_interval(1e6);
        // 3.29 standard deviations of √(2/n) each way.
        assert!((low - (1.0 - 3.29 * 2e-6_f64.sqrt())).abs() < 1e-4, "{low}");
        assert!((high - (1.0 + 3.29 * 2e-6_f64.sqrt())).abs() < 1e-4, "{high}");
    }

    #[test]
    fn memory_counts_fewer_readings() {
        assert!((independent_share(0.9, 400.0) - 0.19 / 1.81).abs() < 1e-12);
        assert!((independent_share(0.05, 100.0) - 1.0).abs() < f64::EPSILON);
        let (lagged, pairs) = lag_one([[1.0, 1.0, -1.0].as_slice()].into_iter());
        assert!(lagged.abs() < f64::EPSILON && (pairs - 2.0).abs() < f64::EPSILON);
    }
}
