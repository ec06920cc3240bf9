//! The suites that others wrote: NIST StRD and Moré-Garbow-Hillstrom.

use least_squares::{Options, Problem, solve};

use crate::suites::{best_of, mgh, nist};

/// Digits NIST certifies for sigma, less what double precision loses on the way: residuals keep
/// 16 digits less log₁₀(‖y‖/‖r‖), at most 10 of them for all sets but `Lanczos1`.
const SIGMA_DIGITS: f64 = 6.0;
/// `Lanczos1` has residuals of 1e-13 on data of 1: three digits of them exist.
const LANCZOS1_SIGMA_DIGITS: f64 = 2.0;

#[test]
fn nist_parameters_are_right_from_both_starts() {
    let mut sum = 0.0;
    for (name, model) in nist::MODELS {
        let problem = nist::Nist::read(name, model);
        for (i, start) in problem.starts.iter().enumerate() {
            let fit = solve(&problem, start.clone(), &Options::default());
            let fit = fit.unwrap_or_else(|e| panic!("{name} start {}: {e}", i + 1));
            let digits = nist::log_relative_error(&fit.point, &problem.certified);
            assert!(digits >= nist::GOAL_DIGITS, "{name} start {}: {digits:.1} digits", i + 1);
            sum += digits;
        }
    }
    let mean = sum / 54.0;
    assert!(mean >= nist::GOAL_MEAN, "mean {mean:.2}");
}

#[test]
fn nist_standard_deviations_come_from_the_covariance() {
    for (name, model) in nist::MODELS {
        let problem = nist::Nist::read(name, model);
        let fit = solve(&problem, problem.starts[1].clone(), &Options::default()).unwrap();
        let variance_factor = fit.variance_factor.unwrap();
        let sigma = fit.standard_uncertainties() * variance_factor.sqrt();
        let digits = nist::log_relative_error(&sigma, &problem.certified_sigma);
        let goal = if name == "Lanczos1" { LANCZOS1_SIGMA_DIGITS } else { SIGMA_DIGITS };
        assert!(digits >= goal, "{name}: {digits:.1} digits");
        assert_eq!(fit.degrees_of_freedom, problem.residual_count() - problem.tangent_dim());
    }
}

#[test]
fn more_garbow_hillstrom_minima_are_found() {
    let mut solved = 0;
    for problem in &mgh::PROBLEMS {
        for scale in mgh::START_SCALES {
            let outcome = solve(problem, problem.start(scale), &Options::default());
            solved +=
                usize::from(best_of(outcome).is_some_and(|b| problem.solved(b.sum_of_squares)));
        }
    }
    assert!(solved >= mgh::GOAL_SOLVED, "{solved} of 57");
}
