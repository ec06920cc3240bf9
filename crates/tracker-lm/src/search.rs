//! The search, and its failures in this crate's words.

use least_squares::{
    BorderedCovariance, BorderedOptions, BorderedPoint, BorderedProblem, BorderedSolution, Report,
    SolveError, bordered_covariance, solve_bordered,
};

use crate::TrackerError;

/// Root-mean-square whitened residual below which a fit is exact: what is left is rounding, and
/// no step can be judged by it.
const EXACT: f64 = 1e-6;

/// Minimises from `start`, with some blocks held there.
pub(crate) fn settle<P: BorderedProblem>(
    problem: &P,
    start: BorderedPoint,
    held: &[usize],
) -> Result<BorderedSolution, TrackerError> {
    match solve_bordered(problem, start, &options(held)) {
        Err(SolveError::Stalled { best, report } | SolveError::NotConverged { best, report })
            if is_exact(&report) =>
        {
            let degrees_of_freedom = report.residuals_used.saturating_sub(report.parameters);
            let variance_factor = Some(2.0 * report.final_cost / count(degrees_of_freedom.max(1)));
            Ok(BorderedSolution {
                point: *best,
                degrees_of_freedom,
                variance_factor,
                report: *report,
            })
        }
        other => other.map_err(in_own_words),
    }
}

fn is_exact(report: &Report) -> bool {
    2.0 * report.final_cost <= EXACT * EXACT * count(report.residuals_used)
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn count(n: usize) -> f64 {
    n as f64
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
