//! The estimate by Levenberg-Marquardt from the closed form, for any uncertainty and loss.

use least_squares::{Loss, RobustRows, Solution, SolveError};

use crate::motion::Moved;
use crate::problem::FitProblem;
use crate::{FrameFitError, Noise, Options};

/// Minimises the weighted squares, or the loss that `options` names, over motions of `problem`.
pub(crate) fn refine<const D: usize>(
    problem: &FitProblem<D>,
    options: &Options,
) -> Result<Solution<Moved<D>>, FrameFitError> {
    let solution = solve(problem, Moved::still(), None)?;
    let Some(loss) = options.loss else { return Ok(solution) };
    // Huber's loss is convex for all but the rotation, so that a start spoilt by outliers is
    // mended before a loss that ignores them could lock on to it.
    let mut convex = solution;
    let passes = if options.noise == Noise::Declared { 1 } else { SCALE_PASSES };
    for _ in 0..passes {
        let scale = robust_sigma(&convex, D, options.noise) * scale_of(loss);
        convex = solve(problem, convex.point, Some(Loss::Huber { scale }))?;
    }
    let scale = robust_sigma(&convex, D, options.noise) * scale_of(loss);
    solve(problem, convex.point, Some(with_scale(loss, scale)))
}

/// Passes over estimated noise and robust fit; the scale settles to a percent in three.
const SCALE_PASSES: usize = 3;

/// Standard deviation of a whitened coordinate: 1 when declared, else from the median distance,
/// which half of the points being bad does not move far.
fn robust_sigma<const D: usize>(
    solution: &Solution<Moved<D>>,
    dimension: usize,
    noise: Noise,
) -> f64 {
    if noise == Noise::Declared {
        return 1.0;
    }
    let residuals = solution.residuals.as_slice().chunks(dimension);
    let mut distances: Vec<f64> = residuals.map(|r| norm_squared(r).sqrt()).collect();
    distances.sort_by(f64::total_cmp);
    let median = distances[distances.len() / 2];
    // Median of the chi distribution with 2 and 3 degrees of freedom.
    let median_of_unit_noise = if dimension == 2 { 1.177_410 } else { 1.538_172 };
    // A fit without redundancy leaves nothing to judge; any positive scale then keeps all points.
    (median / median_of_unit_noise).max(f64::MIN_POSITIVE.sqrt())
}

fn scale_of(loss: Loss) -> f64 {
    match loss {
        Loss::Huber { scale }
        | Loss::Cauchy { scale }
        | Loss::Tukey { scale }
        | Loss::GemanMcClure { scale } => scale,
    }
}

fn with_scale(loss: Loss, scale: f64) -> Loss {
    match loss {
        Loss::Huber { .. } => Loss::Huber { scale },
        Loss::Cauchy { .. } => Loss::Cauchy { scale },
        Loss::Tukey { .. } => Loss::Tukey { scale },
        Loss::GemanMcClure { .. } => Loss::GemanMcClure { scale },
    }
}

fn solve<const D: usize>(
    problem: &FitProblem<D>,
    start: Moved<D>,
    loss: Option<Loss>,
) -> Result<Solution<Moved<D>>, FrameFitError> {
    let options = least_squares::Options {
        gradient_tolerance: rounding_correlation(problem, &start, loss)
            .max(least_squares::Options::default().gradient_tolerance),
        robust: loss.map(|loss| RobustRows::all(D, loss)).into_iter().collect(),
        ..least_squares::Options::default()
    };
    least_squares::solve(problem, start, &options).map_err(translated)
}

/// Correlation between residual and Jacobian that rounding of the coordinates, as a share of the
/// weighted residual, hides.
fn rounding_correlation<const D: usize>(
    problem: &FitProblem<D>,
    at: &Moved<D>,
    loss: Option<Loss>,
) -> f64 {
    let weighted = |residual: &[f64]| {
        let s = norm_squared(residual);
        s * loss.map_or(1.0, |loss| loss.evaluate(s).1)
    };
    let chi2: f64 = problem.whitened(at).as_slice().chunks(D).map(weighted).sum();
    if chi2 <= problem.round_off_chi2 {
        return 1.0;
    }
    (problem.round_off_chi2 / chi2).sqrt()
}

fn norm_squared(residual: &[f64]) -> f64 {
    residual.iter().map(|v| v * v).sum()
}

fn translated<Point>(error: SolveError<Point>) -> FrameFitError {
    match error {
        SolveError::Unobservable { directions, .. } => FrameFitError::Unobservable { directions },
        SolveError::InvalidLoss { scale, .. } => FrameFitError::InvalidLoss { scale },
        SolveError::NotConverged { report, .. } | SolveError::Stalled { report, .. } => {
            FrameFitError::NotConverged { iterations: report.iterations, cost: report.final_cost }
        }
        // Finite input within bounds gives finite residuals and derivatives.
        _ => FrameFitError::NotConverged { iterations: 0, cost: f64::NAN },
    }
}
