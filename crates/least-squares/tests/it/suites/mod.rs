//! Test suites that others wrote, with their known answers.

pub(crate) mod dual;
pub(crate) mod mgh;
pub(crate) mod nist;

use least_squares::{Report, Solution, SolveError};
use nalgebra::DVector;

/// What a search found, whether it may be relied on or not.
pub(crate) struct Best {
    pub(crate) point: DVector<f64>,
    pub(crate) sum_of_squares: f64,
    pub(crate) report: Report,
    /// How it ended, in a word.
    pub(crate) outcome: &'static str,
}

/// The best point of a solution or of the error in its place; `None` where the start is refused.
pub(crate) fn best_of(result: Result<Solution<DVector<f64>>, SolveError>) -> Option<Best> {
    let (point, report, outcome) = match result {
        Ok(solution) => (solution.point, solution.report, "solved"),
        Err(SolveError::NotConverged { best, report }) => (*best, *report, "not converged"),
        Err(SolveError::Stalled { best, report }) => (*best, *report, "stalled"),
        Err(SolveError::Unobservable { best, report, .. }) => (*best, *report, "rank deficient"),
        Err(_) => return None,
    };
    Some(Best { point, sum_of_squares: 2.0 * report.final_cost, report, outcome })
}
