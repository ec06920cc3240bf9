//! The search, and its failures in this crate's words.

use least_squares::{
    BorderedCovariance, BorderedOptions, BorderedPoint, BorderedProblem, BorderedSolution,
    SolveError, bordered_covariance, solve_bordered,
};

use crate::TrackerError;

/// Minimises from `start`, with some blocks held there.
pub(crate) fn settle<P: BorderedProblem>(
    problem: &P,
    start: BorderedPoint,
    held: &[usize],
) -> Result<BorderedSolution, TrackerError> {
    solve_bordered(problem, start, &options(held)).map_err(in_own_words)
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
