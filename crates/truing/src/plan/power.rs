//! With what probability an effect is found.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use statrs::function::beta::beta_reg;

/// Non-centrality beyond which Patnaik's approximation is taken: Poisson weights of its half would
/// leave the range of doubles, and the power is one but for round-off.
const LARGE: f64 = 600.0;

/// Smallest weight of the Poisson series that counts.
const NO_WEIGHT: f64 = 1e-15;

/// Probability that an F test of size `alpha` refuses, at a non-centrality.
///
/// The non-central F law is a mixture of central ones with `directions + 2 j` degrees of freedom, with
/// Poisson weights of half the non-centrality.
pub(super) fn power(noncentrality: f64, directions: usize, dof: usize, alpha: f64) -> f64 {
    let (m, v) = (as_f64(directions), as_f64(dof));
    let Ok(central) = FisherSnedecor::new(m, v) else { return 0.0 };
    let critical = central.inverse_cdf(1.0 - alpha);
    if noncentrality > LARGE {
        let shape = (m + noncentrality).powi(2) / (m + 2.0 * noncentrality);
        let Ok(shifted) = FisherSnedecor::new(shape, v) else { return 0.0 };
        return shifted.sf(critical * m / (m + noncentrality));
    }
    let half = 0.5 * noncentrality;
    let share = m * critical / (m * critical + v);
    let (mut weight, mut missed, mut j) = ((-half).exp(), 0.0, 0.0);
    while j <= half || weight > NO_WEIGHT {
        missed += weight * beta_reg(0.5 * m + j, 0.5 * v, share);
        j += 1.0;
        weight *= half / j;
    }
    1.0 - missed
}

/// Non-centrality at which that probability is `wanted`.
pub(super) fn needed(wanted: f64, directions: usize, dof: usize, alpha: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    // Twenty doublings are beyond any design.
    for _ in 0..20 {
        if power(high, directions, dof, alpha) >= wanted {
            break;
        }
        (low, high) = (high, 2.0 * high);
    }
    // Forty halvings reach round-off.
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if power(middle, directions, dof, alpha) < wanted { low = middle } else { high = middle }
    }
    high
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn as_f64(n: usize) -> f64 {
    n as f64
}

#[cfg(test)]
mod tests {
    use super::{needed, power};

    /// With many degrees of freedom and one direction, that of a normal deviate: 1.645 + 2.576
    /// standard deviations are found 95 times in 100 at the level 0.01.
    #[test]
    fn one_direction_is_a_normal_deviate() {
        let lambda = (1.644_85_f64 + 2.575_83).powi(2);
        assert!((power(lambda, 1, 100_000, 0.01) - 0.95).abs() < 1e-4);
        assert!((needed(0.95, 1, 100_000, 0.01) / lambda - 1.0).abs() < 1e-3);
    }

    #[test]
    fn without_an_effect_the_test_refuses_at_its_level() {
        assert!((power(0.0, 2, 30, 0.05) - 0.05).abs() < 1e-9);
        assert!(power(1e6, 2, 30, 0.05) > 0.999_999);
        assert!(power(1.0, 1, 0, 0.05) < f64::MIN_POSITIVE);
    }
}
