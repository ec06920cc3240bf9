use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use crate::count::count;

/// Probability that an interval covers.
const COVERAGE: f64 = 0.95;

/// Factor from a standard uncertainty to the half width of a 95 % interval.
///
/// 1.96 where the noise is known, Student's quantile where it was estimated with that many degrees
/// of freedom (GUM, G.3): 2.78 with four, 2.04 with thirty. Infinite without any.
#[must_use]
pub fn coverage_factor(degrees_of_freedom: Option<usize>) -> f64 {
    let probability = f64::midpoint(1.0, COVERAGE);
    match degrees_of_freedom {
        None => Normal::standard().inverse_cdf(probability),
        Some(0) => f64::INFINITY,
        Some(dof) => StudentsT::new(0.0, 1.0, count(dof))
            .map_or(f64::INFINITY, |student| student.inverse_cdf(probability)),
    }
}

/// Standard uncertainty with which an interval also covers what other names of an effect give.
///
/// `away` are distances of their estimates from the one reported. Where the names cannot be told
/// apart, any of them may be the true one: the interval reaches as far beyond the farthest as the
/// noise goes one-sidedly. With none away, `std` itself.
#[must_use]
pub fn std_over_names(std: f64, away: impl Iterator<Item = f64>) -> f64 {
    let farthest = away.map(f64::abs).fold(0.0, f64::max);
    let (both, one) = (f64::midpoint(1.0, COVERAGE), COVERAGE);
    let quantile = |probability: f64| Normal::standard().inverse_cdf(probability);
    std.max((farthest + quantile(one) * std) / quantile(both))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables give four digits.
    #[test]
    fn factors_are_those_of_the_tables() {
        let table = [(None, 1.960), (Some(4), 2.776), (Some(30), 2.042), (Some(1), 12.71)];
        for (dof, expected) in table {
            let factor = coverage_factor(dof);
            assert!((factor / expected - 1.0).abs() < 5e-4, "{dof:?}: {factor}");
        }
        assert!(coverage_factor(Some(0)).is_infinite());
    }

    #[test]
    fn other_names_widen_what_they_move() {
        assert!((std_over_names(2.0, std::iter::empty()) - 2.0).abs() < 1e-12);
        // Below what the two-sided interval has beyond the one-sided one nothing changes.
        assert!((std_over_names(1.0, [0.3, -0.3].into_iter()) - 1.0).abs() < 1e-12);
        // 10 + 1.645 over 1.960.
        assert!((std_over_names(1.0, [2.0, -10.0].into_iter()) - 5.9413).abs() < 1e-3);
    }
}
