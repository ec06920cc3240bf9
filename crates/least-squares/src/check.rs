//! Comparison of an analytic Jacobian with differences.

use std::fmt;

use nalgebra::{DMatrix, DVector};

use crate::Problem;

/// Largest step, in units of the one that changes a residual by one standard uncertainty.
const FIRST_STEP: f64 = 1024.0;
/// Factor between steps.
const SHRINK: f64 = 2.0;
/// Steps: the last changes a residual by 1e-5 of a standard uncertainty.
const LEVELS: usize = 28;
/// Orders of extrapolation: the error falls with the eighth power of the step.
const ORDERS: usize = 3;
/// Finest levels, whose scatter is taken as rounding noise.
const NOISY_LEVELS: usize = 5;
/// Factor over the least error so far at which coarser steps are not looked at.
const PAST_THE_MINIMUM: f64 = 1e3;
/// Ratio between two columns' lengths from which the steps are chosen anew.
const FAR_OFF: f64 = 10.0;

/// Analytic Jacobian against differences: the entry that agrees worst.
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
    ///
    /// A right Jacobian of smooth residuals comes out at 1e-9 or better; a wrong sign, factor or
    /// frame at 1e-3 or worse.
    #[must_use]
    pub fn worst_relative_error(&self) -> f64 {
        self.worst.relative_error
    }
}

impl fmt::Display for JacobianCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let JacobianEntry { row, column, name, analytic, numeric, relative_error } = &self.worst;
        write!(f, "worst entry: residual {row} by {name} (direction {column}), ")?;
        write!(f, "analytic {analytic:e}, numeric {numeric:e}, ")?;
        write!(f, "{relative_error:.1e} of the column's largest")
    }
}

/// Compares [`Problem::jacobian`] at `at` with Ridders' extrapolated central differences.
///
/// Steps are taken with [`Problem::retract`], so the check covers the tangent space too: its
/// side, order and scale. Costs some 60 residual evaluations per column. Where `at` is no point of
/// the problem ([`Problem::is_point`]), the error is infinite.
pub fn check_jacobian<P: Problem>(problem: &P, at: &P::Point) -> JacobianCheck {
    let mut worst = JacobianEntry {
        row: 0,
        column: 0,
        name: String::new(),
        analytic: 0.0,
        numeric: 0.0,
        relative_error: 0.0,
    };
    if !problem.is_point(at) {
        let nothing = f64::NAN;
        let relative_error = f64::INFINITY;
        worst = JacobianEntry { analytic: nothing, numeric: nothing, relative_error, ..worst };
        return JacobianCheck { worst };
    }
    let mut analytic = DMatrix::zeros(problem.residual_count(), problem.tangent_dim());
    problem.jacobian(at, &mut analytic);
    for (column, expected) in analytic.column_iter().enumerate() {
        let numeric = differentiate(problem, at, column, expected.amax());
        let largest = expected.amax().max(numeric.amax());
        for (row, (&analytic, &numeric)) in expected.iter().zip(&numeric).enumerate() {
            let error = (analytic - numeric).abs();
            let relative_error = if error == 0.0 { 0.0 } else { error / largest };
            // NaN counts as worst, and stays so.
            if relative_error > worst.relative_error || relative_error.is_nan() {
                let name = problem.parameter_name(column);
                worst = JacobianEntry { row, column, name, analytic, numeric, relative_error };
            }
        }
    }
    JacobianCheck { worst }
}

/// One column by differences; the expected length only sets the steps.
fn differentiate<P: Problem>(
    problem: &P,
    at: &P::Point,
    column: usize,
    expected: f64,
) -> DVector<f64> {
    let usable = |length: f64| length > 0.0 && length.is_finite();
    let first = ridders(problem, at, column, if usable(expected) { expected } else { 1.0 });
    let found = first.derivative.amax();
    let ratio = found / expected;
    if !usable(found) || (FAR_OFF.recip()..FAR_OFF).contains(&ratio) {
        return first.derivative;
    }
    let second = ridders(problem, at, column, found);
    if second.error < first.error { second.derivative } else { first.derivative }
}

struct Extrapolated {
    derivative: DVector<f64>,
    /// Estimated error of its worst entry.
    error: f64,
}

/// Ridders (1982): central differences over shrinking steps, extrapolated to zero.
///
/// The level kept is the first minimum of the error, from the finest step on: the change by the
/// extrapolation plus the rounding noise of the differences. Steps so coarse that the residuals
/// saturate agree with each other on nonsense, and are never reached.
fn ridders<P: Problem>(problem: &P, at: &P::Point, column: usize, length: f64) -> Extrapolated {
    let mut steps = Vec::with_capacity(LEVELS);
    let mut h = FIRST_STEP / length;
    for _ in 0..LEVELS {
        steps.push((h, central(problem, at, column, h)));
        h /= SHRINK;
    }
    let noise = steps[LEVELS - NOISY_LEVELS..]
        .windows(2)
        .map(|pair| pair[1].0 * (&pair[1].1 - &pair[0].1).amax())
        .fold(0.0, f64::max);
    let rows = problem.residual_count();
    let mut best =
        Extrapolated { derivative: DVector::repeat(rows, f64::NAN), error: f64::INFINITY };
    for window in steps.windows(ORDERS + 1).rev() {
        let (derivative, change) = extrapolate(window);
        let error = change + noise / window[ORDERS].0;
        if error < best.error {
            best = Extrapolated { derivative, error };
        } else if error > PAST_THE_MINIMUM * best.error {
            break;
        }
    }
    best
}

/// Richardson's tableau over steps that halve; also the last change of any entry.
fn extrapolate(steps: &[(f64, DVector<f64>)]) -> (DVector<f64>, f64) {
    let mut level: Vec<DVector<f64>> = steps.iter().map(|(_, d)| d.clone()).collect();
    let mut factor = 1.0;
    let mut change = f64::INFINITY;
    while level.len() > 1 {
        factor *= SHRINK * SHRINK;
        let next: Vec<_> =
            level.windows(2).map(|w| (&w[1] * factor - &w[0]) / (factor - 1.0)).collect();
        change = (&next[next.len() - 1] - &level[level.len() - 1]).amax();
        level = next;
    }
    (level.remove(0), change)
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
