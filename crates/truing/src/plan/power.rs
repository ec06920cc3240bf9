//! With what probability an effect is found.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// Probability that an F test of size `alpha` refuses, at a non-centrality.
///
/// By Patnaik's (1949) approximation of the non-central F law, good to a few per cent.
pub(super) fn power(noncentrality: f64, directions: usize, dof: usize, alpha: f64) -> f64 {
    let (m, v) = (as_f64(directions), as_f64(dof));
    let Ok(central) = FisherSnedecor::new(m, v) else { return 0.0 };
    let critical = central.inverse_cdf(1.0 - alpha);
    let shape = (m + noncentrality).powi(2) / (m + 2.0 * noncentrality);
    let Ok(shifted) = FisherSnedecor::new(shape, v) else { return 0.0 };
    shifted.sf(critical * m / (m + noncentrality))
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
        assert!((power(lambda, 1, 100_000, 0.01) - 0.95).abs() < 0.02);
        assert!((needed(0.95, 1, 100_000, 0.01) / lambda - 1.0).abs() < 0.05);
    }

    #[test]
    fn without_an_effect_the_test_refuses_at_its_level() {
        assert!((power(0.0, 2, 30, 0.05) - 0.05).abs() < 1e-9);
        assert!(power(1e6, 2, 30, 0.05) > 0.999_999);
        assert!(power(1.0, 1, 0, 0.05) < f64::MIN_POSITIVE);
    }
}
