//! The Levenberg-Marquardt iteration.

use nalgebra::{DMatrix, DVector};

use crate::covariance::Factored;
use crate::linearised::{Evaluated, Linearised};
use crate::{Options, Problem, Report, Solution, SolveError, Termination};

/// Finds the point that minimises `½ Σ ρ(‖rᵢ‖²)`, starting from `start`.
///
/// # Errors
///
/// See [`SolveError`]: every variant means that there is no estimate to rely on.
/// [`SolveError::NotConverged`] and [`SolveError::Unobservable`] carry the best point found.
pub fn solve<P: Problem>(
    problem: &P,
    start: P::Point,
    options: &Options,
) -> Result<Solution<P::Point>, SolveError<P::Point>> {
    let mut point = start;
    let mut at = Linearised::at(problem, &point, options)?;
    let mut trial = Evaluated::zeros(problem.residual_count());
    let initial_cost = at.evaluated.cost;
    let n = at.free.len();
    let mut scale = DVector::zeros(n);
    let mut damping = options.initial_damping;
    let mut growth = 2.0;
    let (mut iterations, mut residual_evaluations, mut jacobian_evaluations) = (0, 1, 1);
    let mut path = DVector::<f64>::zeros(n);
    let termination = 'search: loop {
        for (s, c) in scale.iter_mut().zip(at.jacobian.column_iter()) {
            *s = f64::max(*s, c.norm());
        }
        let scale_or_one = scale.map(|s: f64| if s > 0.0 { s } else { 1.0 });
        if n == 0 || at.gradient_correlation() <= options.gradient_tolerance {
            break Some(Termination::Gradient);
        }
        if iterations == options.max_iterations {
            break None;
        }
        loop {
            let step = damped_step(&at, &scale_or_one, damping);
            let scaled = step.component_mul(&scale_or_one).norm();
            let predicted =
                0.5 * ((&at.jacobian * &step).norm_squared()) + damping * scaled * scaled;
            if predicted <= options.cost_tolerance.max(1e-300) * at.evaluated.cost {
                break 'search Some(Termination::Cost);
            }
            if scaled <= options.step_tolerance * path.component_mul(&scale_or_one).norm() {
                break 'search Some(Termination::Step);
            }
            let mut full = DVector::zeros(at.tangent_dim);
            for (k, &i) in at.free.iter().enumerate() {
                full[i] = step[k];
            }
            let candidate = problem.retract(&point, &full);
            trial.fill(problem, &candidate, options);
            residual_evaluations += 1;
            let gain = (at.evaluated.cost - trial.cost) / predicted;
            if trial.cost < at.evaluated.cost && gain > 1e-4 {
                path += &step;
                point = candidate;
                std::mem::swap(&mut at.evaluated, &mut trial);
                at.linearise(problem, &point)?;
                jacobian_evaluations += 1;
                iterations += 1;
                damping *= f64::max(1.0 / 3.0, 1.0 - (2.0 * gain - 1.0).powi(3));
                damping = damping.max(1e-30);
                growth = 2.0;
                break;
            }
            damping *= growth;
            growth *= 2.0;
            if damping > 1e30 {
                break 'search Some(Termination::Cost);
            }
        }
    };
    let factored = Factored::new(&at, options.rank_tolerance);
    let report = Report {
        termination,
        iterations,
        residual_evaluations,
        jacobian_evaluations,
        initial_cost,
        ..at.report(&factored)
    };
    finish(problem, point, at, &factored, report)
}

fn finish<P: Problem>(
    problem: &P,
    point: P::Point,
    at: Linearised,
    factored: &Factored,
    report: Report,
) -> Result<Solution<P::Point>, SolveError<P::Point>> {
    let (best, boxed) = (Box::new(point.clone()), Box::new(report.clone()));
    if factored.rank < at.free.len() {
        let directions = factored.free_directions(problem, &at);
        return Err(SolveError::Unobservable { directions, best, report: boxed });
    }
    if report.termination.is_none() {
        return Err(SolveError::NotConverged { best, report: boxed });
    }
    Ok(Solution {
        point,
        covariance: factored.covariance(&at),
        degrees_of_freedom: at.degrees_of_freedom(),
        variance_factor: at.variance_factor(),
        residuals: at.evaluated.residuals,
        weights: at.evaluated.weights,
        report,
    })
}

fn damped_step(at: &Linearised, scale: &DVector<f64>, damping: f64) -> DVector<f64> {
    let (rows, n) = at.jacobian.shape();
    let mut stacked = DMatrix::zeros(rows + n, n);
    stacked.rows_mut(0, rows).copy_from(&at.jacobian);
    for j in 0..n {
        let s = scale[j];
        stacked.view_mut((0, j), (rows, 1)).unscale_mut(s);
        stacked[(rows + j, j)] = damping.sqrt();
    }
    let mut rhs = DVector::zeros(rows + n);
    rhs.rows_mut(0, rows).copy_from(&-&at.weighted);
    let qr = stacked.qr();
    qr.q_tr_mul(&mut rhs);
    let mut step = rhs.rows(0, n).into_owned();
    qr.r().solve_upper_triangular_mut(&mut step);
    step.component_div_assign(scale);
    step
}
