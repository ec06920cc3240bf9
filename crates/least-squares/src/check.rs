//! Comparison of an analytic Jacobian with differences.

use std::fmt;

use nalgebra::{DMatrix, DVector};

use crate::Problem;

/// Analytic Jacobian against differences, and the entry that agrees worst.
#[derive(Clone, Debug, PartialEq)]
pub struct JacobianCheck {
    /// Entry with the largest relative error.
    pub worst: JacobianEntry,
}

/// One entry of a Jacobian, computed both ways.
#[derive(Clone, Debug, PartialEq)]
pub struct JacobianEntry {
    /// Residual.
    pub row: usize,
    /// Tangent direction.
    pub column: usize,
    /// Name of the tangent direction.
    pub name: String,
    /// What the problem says.
    pub analytic: f64,
    /// What differences say.
    pub numeric: f64,
    /// `|analytic − numeric|` over the largest entry of the column, analytic or numeric.
    pub relative_error: f64,
}

impl JacobianCheck {
    /// Largest error of an entry, relative to the largest entry of its column.
    #[must_use]
    pub fn worst_relative_error(&self) -> f64 {
        self.worst.relative_error
    }
}

impl fmt::Display for JacobianCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let w = &self.worst;
        write!(
            f,
            "worst entry: residual {} by {} (direction {}): analytic {:e}, numeric {:e}, relative error {:.1e}",
            w.row, w.name, w.column, w.analytic, w.numeric, w.relative_error
        )
    }
}

/// Compares [`Problem::jacobian`] at `at` with Ridders' extrapolated central differences.
pub fn check_jacobian<P: Problem>(problem: &P, at: &P::Point) -> JacobianCheck {
    let (rows, columns) = (problem.residual_count(), problem.tangent_dim());
    let mut analytic = DMatrix::zeros(rows, columns);
    problem.jacobian(at, &mut analytic);
    let mut worst = JacobianEntry {
        row: 0,
        column: 0,
        name: String::new(),
        analytic: 0.0,
        numeric: 0.0,
        relative_error: 0.0,
    };
    for column in 0..columns {
        let numeric = ridders(problem, at, column);
        let scale = analytic.column(column).amax().max(numeric.amax());
        for row in 0..rows {
            let (a, n) = (analytic[(row, column)], numeric[row]);
            let relative_error = if a == n { 0.0 } else { (a - n).abs() / scale };
            if relative_error > worst.relative_error || relative_error.is_nan() {
                let name = problem.parameter_name(column);
                worst =
                    JacobianEntry { row, column, name, analytic: a, numeric: n, relative_error };
            }
        }
    }
    JacobianCheck { worst }
}

fn central<P: Problem>(problem: &P, at: &P::Point, column: usize, h: f64) -> DVector<f64> {
    let mut step = DVector::zeros(problem.tangent_dim());
    let mut forward = DVector::zeros(problem.residual_count());
    let mut backward = forward.clone();
    step[column] = h;
    problem.residuals(&problem.retract(at, &step), &mut forward);
    step[column] = -h;
    problem.residuals(&problem.retract(at, &step), &mut backward);
    (forward - backward) / (2.0 * h)
}

/// Ridders (1982): Richardson extrapolation over shrinking steps, the entry with the least
/// estimated error kept.
fn ridders<P: Problem>(problem: &P, at: &P::Point, column: usize) -> DVector<f64> {
    const SHRINK: f64 = 2.0;
    const LEVELS: usize = 40;
    let mut best = DVector::zeros(problem.residual_count());
    let mut best_error = DVector::repeat(problem.residual_count(), f64::INFINITY);
    let mut previous: Vec<DVector<f64>> = Vec::new();
    let mut h = 1e2;
    for _ in 0..LEVELS {
        let mut current = vec![central(problem, at, column, h)];
        let mut factor = SHRINK * SHRINK;
        for (k, coarse) in previous.iter().take(4).enumerate() {
            let fine = &current[k];
            let next = (fine * factor - coarse) / (factor - 1.0);
            for row in 0..best.len() {
                let error = (next[row] - fine[row]).abs().max((next[row] - coarse[row]).abs());
                if error < best_error[row] {
                    best_error[row] = error;
                    best[row] = next[row];
                }
            }
            factor *= SHRINK * SHRINK;
            current.push(next);
        }
        previous = current;
        h /= SHRINK;
    }
    best
}
