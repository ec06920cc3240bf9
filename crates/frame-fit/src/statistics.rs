//! Tail probabilities and quantiles.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal, StudentsT};
use statrs::function::beta::beta_reg;
use statrs::function::gamma::gamma_lr;

/// A count as a number.
#[expect(clippy::cast_precision_loss, reason = "counts of points are far below 2^53")]
pub(crate) fn ratio(count: usize) -> f64 {
    count as f64
}

/// Statistic beyond which the probability is nought; squares and products stay finite.
const LARGEST_STATISTIC: f64 = 1e100;

/// Probability that F with these degrees of freedom exceeds `f`.
pub(crate) fn f_tail(f: f64, numerator_dof: usize, denominator_dof: usize) -> f64 {
    let tail = FisherSnedecor::new(ratio(numerator_dof), ratio(denominator_dof));
    tail.map_or(f64::NAN, |d| if f.is_nan() { f } else { d.sf(f.clamp(0.0, LARGEST_STATISTIC)) })
}

/// Probability that χ² exceeds `chi2`.
pub(crate) fn chi2_tail(chi2: f64, dof: usize) -> f64 {
    let tail = ChiSquared::new(ratio(dof));
    tail.map_or(f64::NAN, |d| if chi2.is_nan() { chi2 } else { d.sf(chi2.min(LARGEST_STATISTIC)) })
}

/// Quantile of the standard normal distribution.
pub(crate) fn normal_quantile(probability: f64) -> f64 {
    Normal::standard().inverse_cdf(probability)
}

/// Quantile of Student's distribution.
pub(crate) fn student_quantile(probability: f64, dof: usize) -> f64 {
    StudentsT::new(0.0, 1.0, ratio(dof)).map_or(f64::NAN, |d| d.inverse_cdf(probability))
}

/// Non-centrality with which a test of `numerator_dof` at `significance` rejects with `power`.
///
/// χ² test without `denominator_dof`, F test with it. NaN where the levels are not probabilities.
pub(crate) fn noncentrality(
    significance: f64,
    power: f64,
    numerator_dof: usize,
    denominator_dof: Option<usize>,
) -> f64 {
    let probability = |p: f64| p > 0.0 && p < 1.0;
    if !probability(significance) || !probability(power) || power <= significance {
        return f64::NAN;
    }
    let half = 0.5 * ratio(numerator_dof);
    // Probability of acceptance of a central variable with 2·extra more degrees of freedom.
    let accepted: Box<dyn Fn(f64) -> f64> = match denominator_dof {
        None => {
            let Ok(central) = ChiSquared::new(2.0 * half) else { return f64::NAN };
            let critical = central.inverse_cdf(1.0 - significance);
            Box::new(move |extra| gamma_lr(half + extra, 0.5 * critical))
        }
        Some(dof) => {
            let Ok(central) = FisherSnedecor::new(2.0 * half, ratio(dof)) else { return f64::NAN };
            let critical = central.inverse_cdf(1.0 - significance) * 2.0 * half;
            let share = critical / (critical + ratio(dof));
            Box::new(move |extra| beta_reg(half + extra, 0.5 * ratio(dof), share))
        }
    };
    // The root lies where acceptance has fallen to 1 − power; it falls with the non-centrality.
    let (mut low, mut high) = (0.0, 1.0);
    while mixture(high, &accepted) > 1.0 - power && high < LARGEST_NONCENTRALITY {
        low = high;
        high *= 2.0;
    }
    for _ in 0..BISECTIONS {
        let middle = f64::midpoint(low, high);
        if mixture(middle, &accepted) > 1.0 - power {
            low = middle;
        } else {
            high = middle;
        }
    }
    f64::midpoint(low, high)
}

/// Beyond it Poisson weights start from zero in double precision; 36 standard uncertainties.
const LARGEST_NONCENTRALITY: f64 = 1300.0;
/// Halvings to twelve digits.
const BISECTIONS: usize = 40;

/// Probability of acceptance under non-centrality `lambda`: a Poisson mixture of central ones.
fn mixture(lambda: f64, accepted: &dyn Fn(f64) -> f64) -> f64 {
    let mean = 0.5 * lambda;
    let mut weight = (-mean).exp();
    let (mut sum, mut covered) = (0.0, 0.0);
    let mut extra = 0.0;
    while covered < 1.0 - 1e-12 && extra < mean + 20.0 * mean.sqrt() + 30.0 {
        sum += weight * accepted(extra);
        covered += weight;
        extra += 1.0;
        weight *= mean / extra;
    }
    sum
}
