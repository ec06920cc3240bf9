//! How the solver does on NIST StRD and Moré-Garbow-Hillstrom; fails below the goals.
//!
//! One set of options, the defaults, for every problem.
#![expect(clippy::print_stdout, reason = "its tables are what it is for")]

#[path = "../tests/it/suites/mod.rs"]
mod suites;

use std::process::ExitCode;

use least_squares::{Options, Problem, solve};
use nalgebra::DVector;
use suites::{Best, best_of, mgh, nist};

fn main() -> ExitCode {
    let nist = nist_table();
    println!();
    let mgh = mgh_table();
    println!();
    as_in_ceres();
    if nist && mgh { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn nist_table() -> bool {
    println!("NIST StRD: correct digits (LRE) of the worst parameter, and of the worst sigma");
    println!("{:<10} start  digits  sigma  residuals  Jacobians  searches", "problem");
    let (mut solved, mut digits_sum, mut evaluations) = (0, 0.0, 0);
    for (name, model) in nist::MODELS {
        let problem = nist::Nist::read(name, model);
        for (i, start) in problem.starts.iter().enumerate() {
            let result = solve(&problem, start.clone(), &Options::default());
            let sigma = result.as_ref().ok().map_or(0.0, |fit| {
                let factor = fit.variance_factor.unwrap_or(f64::NAN).sqrt();
                let sigma = fit.standard_uncertainties() * factor;
                nist::log_relative_error(&sigma, &problem.certified_sigma)
            });
            let usable = result.is_ok();
            let best = best_of(result).expect("NIST starts are finite");
            let digits = nist::log_relative_error(&best.point, &problem.certified);
            solved += usize::from(usable && digits >= nist::GOAL_DIGITS);
            digits_sum += digits;
            evaluations += best.report.residual_evaluations;
            println!("{name:<10} {:>5}  {digits:>6.1}  {sigma:>5.1}  {}", i + 1, work(&best));
        }
    }
    let mean = digits_sum / 54.0;
    let reached = solved == 54 && mean >= nist::GOAL_MEAN;
    println!(
        "{solved} of 54 starts with at least {} digits, mean {mean:.2}, {evaluations} residual \
         evaluations; goal 54 and {}: {}",
        nist::GOAL_DIGITS,
        nist::GOAL_MEAN,
        verdict(reached)
    );
    reached
}

fn mgh_table() -> bool {
    println!("Moré-Garbow-Hillstrom: Σ r² right to 1e-4 from the start × 1, 10, 100");
    println!(
        "{:<18} {:>5}  {:<6} {:>12} {:>12}  residuals  Jacobians  searches  outcome",
        "problem", "start", "solved", "sum", "optimum"
    );
    let (mut solved, mut evaluations) = (0, 0);
    for problem in &mgh::PROBLEMS {
        for scale in mgh::START_SCALES {
            let (is_solved, residuals) = mgh_row(problem, scale);
            solved += usize::from(is_solved);
            evaluations += residuals;
        }
    }
    let reached = solved >= mgh::GOAL_SOLVED;
    println!(
        "{solved} of 57 starts, {evaluations} residual evaluations; goal {}: {}",
        mgh::GOAL_SOLVED,
        verdict(reached)
    );
    reached
}

fn as_in_ceres() {
    println!("The two problems that Ceres states otherwise, as it does (not counted above)");
    for problem in &mgh::AS_IN_CERES {
        for scale in mgh::START_SCALES {
            mgh_row(problem, scale);
        }
    }
}

/// Prints one start; whether it is solved, and the residual evaluations it took.
fn mgh_row(problem: &mgh::Mgh, scale: f64) -> (bool, usize) {
    let Some(best) = best_of(solve(problem, problem.start(scale), &Options::default())) else {
        let overflow = largest_residual(problem, scale);
        println!(
            "{:<18} {scale:>5}  no     start refused: a residual of {overflow:.0e} has no square",
            problem.name
        );
        return (false, 1);
    };
    let solved = problem.solved(best.sum_of_squares);
    println!(
        "{:<18} {scale:>5}  {:<6} {:>12.5e} {:>12.5e}  {}  {}",
        problem.name,
        if solved { "yes" } else { "no" },
        best.sum_of_squares,
        problem.optimum,
        work(&best),
        best.outcome
    );
    (solved, best.report.residual_evaluations)
}

fn largest_residual(problem: &mgh::Mgh, scale: f64) -> f64 {
    let mut residuals = DVector::zeros(problem.residual_count());
    problem.residuals(&problem.start(scale), &mut residuals);
    residuals.amax()
}

fn work(best: &Best) -> String {
    let report = &best.report;
    format!(
        "{:>9}  {:>9}  {:>8}",
        report.residual_evaluations, report.jacobian_evaluations, report.searches
    )
}

fn verdict(reached: bool) -> &'static str {
    if reached { "reached" } else { "MISSED" }
}
