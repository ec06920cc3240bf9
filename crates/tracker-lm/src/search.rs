//! The search, and its failures in this crate's words.

use least_squares::{
    BorderedCovariance, BorderedOptions, BorderedPoint, BorderedProblem, BorderedSolution,
    SolveError, bordered_covariance, solve_bordered,
};

use crate::TrackerError;

/// Steps of a search before it gives up: a well-posed survey takes under 20.
pub(crate) const MOST_STEPS: usize = 100;

/// Minimises from `start` in so many steps at most, with some blocks held there.
pub(crate) fn settle<P: BorderedProblem>(
    problem: &P,
    start: BorderedPoint,
    held: &[usize],
    max_iterations: usize,
) -> Result<BorderedSolution, TrackerError> {
    let options = BorderedOptions { max_iterations, ..options(held) };
    solve_bordered(problem, start, &options).map_err(in_own_words)
}

/// Covariance at a minimum.
pub(crate) fn covariance<'a, P: BorderedProblem>(
    problem: &'a P,
    point: &'a BorderedPoint,
    held: &[usize],
) -> Result<BorderedCovariance<'a, P>, TrackerError> {
    bordered_covariance(problem, point, &options(held)).map_err(in_own_words)
}

fn options(held: &[usize]) -> BorderedOptions {
    BorderedOptions { held_blocks: held.to_vec(), ..BorderedOptions::default() }
}

fn in_own_words(error: SolveError<BorderedPoint>) -> TrackerError {
    match error {
        SolveError::Unobservable { directions, .. } => TrackerError::Unobservable { directions },
        SolveError::NotConverged { report, .. } | SolveError::Stalled { report, .. } => {
            TrackerError::NotConverged { report }
        }
        _ => TrackerError::NotFinite,
    }
}
