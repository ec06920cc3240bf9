use super::block::{Place, robust_cost};
use super::passes::{Setting, chunk_length};
use super::program::Program;
use super::rank::Rank;
use super::search::{Ended, Search};
use super::{BorderedOptions, BorderedPoint, BorderedProblem, BorderedSolution};
use crate::{Report, SolveError};

/// Least pivot from which the elimination itself shows full rank: that of a free direction is
/// rounding, some 1e-14.
const SAFE_PIVOT: f64 = 1e-11;

/// Minimises `½ Σ ρ(r²)` over the shared point and all blocks.
///
/// Blocks are cut into chunks that depend on their number alone and are added up in one order, so
/// that any number of threads gives the same bits. Threads are those of the current rayon pool.
///
/// # Errors
///
/// [`SolveError::NotConverged`] and [`SolveError::Stalled`] with the best point found,
/// [`SolveError::Unobservable`] when the data leave a direction free, and the errors of bad
/// input.
pub fn solve_bordered<P: BorderedProblem>(
    problem: &P,
    start: BorderedPoint,
    options: &BorderedOptions,
) -> Result<BorderedSolution, SolveError<BorderedPoint>> {
    let mut program = Program::new(problem, &start, options)?;
    program.sort_chunks(chunk_length(&program));
    let robust = &options.robust;
    let mut search = Search::new(Setting { problem, program: &program, robust }, options, start);
    let ended = search.run();
    let place = Place { problem, program: &program, robust, point: &search.point };
    if ended == Ended::NonFinite {
        super::diagnose::all_finite(place)?;
    }
    let tally = Tally::new(place, Some(2.0 * search.cost));
    let mut report = report_of(&search, &program, &tally);
    if search.least_pivot() < SAFE_PIVOT || !matches!(ended, Ended::Converged(_)) {
        let rank = place.rank(&place.shared(), options.rank_tolerance);
        report.condition = rank.condition;
        report.rank -= rank.directions.len();
        if !rank.directions.is_empty() {
            let (best, report) = (Box::new(search.point), Box::new(report));
            return Err(SolveError::Unobservable { directions: rank.directions, best, report });
        }
    }
    match ended {
        Ended::Converged(termination) => report.termination = Some(termination),
        Ended::Stalled => {
            let (best, report) = (Box::new(search.point), Box::new(report));
            return Err(SolveError::Stalled { best, report });
        }
        Ended::OutOfIterations | Ended::NonFinite => {
            let (best, report) = (Box::new(search.point), Box::new(report));
            return Err(SolveError::NotConverged { best, report });
        }
    }
    Ok(BorderedSolution {
        point: search.point,
        degrees_of_freedom: tally.degrees_of_freedom(&program),
        variance_factor: tally.variance_factor(&program),
        report,
    })
}

fn report_of<P: BorderedProblem>(
    search: &Search<'_, P>,
    program: &Program,
    tally: &Tally,
) -> Report {
    Report {
        termination: None,
        searches: 1,
        iterations: search.iterations,
        residual_evaluations: search.residual_evaluations,
        jacobian_evaluations: search.jacobian_evaluations,
        initial_cost: search.initial_cost,
        final_cost: search.cost,
        gradient: search.gradient,
        rank: program.parameters(),
        condition: search.least_pivot().sqrt().recip(),
        residuals_given: tally.given,
        residuals_used: tally.used,
        parameters: program.parameters(),
    }
}

/// Report of a point that no search has found.
pub(super) fn report_at(program: &Program, tally: &Tally, rank: &Rank) -> Report {
    Report {
        termination: None,
        searches: 0,
        iterations: 0,
        residual_evaluations: 1,
        jacobian_evaluations: 1,
        initial_cost: tally.cost,
        final_cost: tally.cost,
        gradient: f64::NAN,
        rank: program.parameters() - rank.directions.len(),
        condition: rank.condition,
        residuals_given: tally.given,
        residuals_used: tally.used,
        parameters: program.parameters(),
    }
}

/// Residuals there are and how many of them count.
pub(super) struct Tally {
    given: usize,
    used: usize,
    cost: f64,
    /// `Σ w r²`.
    weighted: f64,
}

impl Tally {
    /// `Σ ρ` may be known already.
    pub(super) fn new<P: BorderedProblem>(place: Place<'_, P>, twice_cost: Option<f64>) -> Self {
        match twice_cost {
            Some(squares) if place.robust.is_empty() => {
                let of_blocks = (0..place.program.block_count)
                    .map(|block| place.problem.observed_count(block))
                    .sum::<usize>();
                let given = of_blocks + place.problem.shared_residual_count();
                Self { given, used: given, cost: 0.5 * squares, weighted: squares }
            }
            _ => Self::evaluated(place),
        }
    }

    fn evaluated<P: BorderedProblem>(place: Place<'_, P>) -> Self {
        let Place { problem, program, robust, point } = place;
        let mut residuals = vec![0.0; program.limits.rows];
        let mut root_weights = vec![1.0; program.limits.rows];
        let mut tally = Self { given: 0, used: 0, cost: 0.0, weighted: 0.0 };
        for block in 0..program.block_count {
            let rows = program.compiled(block).limits.rows;
            let residuals = &mut residuals[..rows];
            problem.residuals(block, &point.shared, place.block(block), residuals);
            let weights = &mut root_weights[..rows];
            tally.cost += 0.5 * robust_cost(robust, residuals, weights);
            let given = problem.observed_count(block);
            let rejected = weights.iter().filter(|w| **w == 0.0).count();
            tally.given += given;
            tally.used += given.saturating_sub(rejected);
            tally.weighted +=
                residuals.iter().zip(weights).map(|(r, w)| (*w * r).powi(2)).sum::<f64>();
        }
        let rows = problem.shared_residual_count();
        let mut residuals = vec![0.0; rows];
        if rows > 0 {
            let mut jacobian = vec![0.0; rows * program.shared_dim];
            problem.linearise_shared(&point.shared, &mut residuals, &mut jacobian);
        }
        let squares: f64 = residuals.iter().map(|r| r * r).sum();
        tally.given += rows;
        tally.used += rows;
        tally.cost += 0.5 * squares;
        tally.weighted += squares;
        tally
    }

    pub(super) fn degrees_of_freedom(&self, program: &Program) -> usize {
        self.used.saturating_sub(program.parameters())
    }

    pub(super) fn variance_factor(&self, program: &Program) -> Option<f64> {
        let degrees_of_freedom = self.degrees_of_freedom(program);
        #[expect(clippy::cast_precision_loss, reason = "row counts are far below 2^53")]
        (degrees_of_freedom > 0).then(|| self.weighted / degrees_of_freedom as f64)
    }
}
