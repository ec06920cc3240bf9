//! Tail probabilities and quantiles.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal, StudentsT};

/// A count as a number.
#[expect(clippy::cast_precision_loss, reason = "counts of points are far below 2^53")]
pub(crate) fn ratio(count: usize) -> f64 {
    count as f64
}

/// Probability that F with these degrees of freedom exceeds `f`.
pub(crate) fn f_tail(f: f64, numerator_dof: usize, denominator_dof: usize) -> f64 {
    FisherSnedecor::new(ratio(numerator_dof), ratio(denominator_dof))
        .map_or(f64::NAN, |d| d.sf(f.max(0.0)))
}

/// Probability that χ² exceeds `chi2`.
pub(crate) fn chi2_tail(chi2: f64, dof: usize) -> f64 {
    ChiSquared::new(ratio(dof)).map_or(f64::NAN, |d| d.sf(chi2.max(0.0)))
}

/// Quantile of the standard normal distribution.
pub(crate) fn normal_quantile(probability: f64) -> f64 {
    Normal::standard().inverse_cdf(probability)
}

/// Quantile of Student's distribution.
pub(crate) fn student_quantile(probability: f64, dof: usize) -> f64 {
    StudentsT::new(0.0, 1.0, ratio(dof)).map_or(f64::NAN, |d| d.inverse_cdf(probability))
}
