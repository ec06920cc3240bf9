//! One Levenberg-Marquardt search from one point.

mod step;

use nalgebra::DVector;

use crate::linearised::{Evaluated, Linearised, NonFinite};
use crate::qr::Qr;
use crate::{Options, Problem, SolveError, Termination};

/// Share of the cost below which its rounding hides a decrease: the sum of some hundred squares
/// is good to about 1e-15.
const COST_RESOLUTION: f64 = 1e-14;
/// A polishing step has to shrink the gradient by this factor to be followed by another.
const POLISH_RATE: f64 = 0.9;
/// Correlation that the cost cannot resolve: the square root of [`COST_RESOLUTION`].
const UNRESOLVED_CORRELATION: f64 = 1e-7;
/// Share of the start's residual below which nothing is left to fit.
const NOTHING_LEFT: f64 = 1e-31;

/// How a search scales and bends its steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Style {
    pub(crate) initial_damping: f64,
    /// Least factor on the damping after a step that went as promised (Nielsen 1999: 1/3).
    pub(crate) relief: f64,
    /// Share of the largest column length so far that the next step's scale keeps: 1 forgets
    /// nothing (Moré 1978), less follows models whose sensitivity falls by orders of magnitude.
    pub(crate) scale_memory: f64,
    /// Whether steps bend along the model's curvature (geodesic acceleration).
    pub(crate) accelerate: bool,
}

/// How a search ended.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Ended {
    Converged(Termination),
    /// No step lowers the cost although the Jacobian promises it.
    Stalled,
    OutOfIterations,
    NonFinite(NonFinite),
}

/// Work done.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counts {
    pub(crate) searches: usize,
    pub(crate) iterations: usize,
    pub(crate) residuals: usize,
    pub(crate) jacobians: usize,
}

/// Where a search ended.
pub(crate) struct Found<Point> {
    pub(crate) point: Point,
    pub(crate) at: Linearised,
    pub(crate) initial_cost: f64,
    /// Sum of all steps, by free direction.
    pub(crate) path: DVector<f64>,
    pub(crate) ended: Ended,
}

pub(crate) fn search<P: Problem>(
    problem: &P,
    start: P::Point,
    options: &Options,
    style: Style,
    counts: &mut Counts,
) -> Result<Found<P::Point>, SolveError<P::Point>> {
    counts.searches += 1;
    counts.residuals += 1;
    let at = Linearised::evaluate(problem, &start, options)?;
    let mut search = Search::new(problem, options, style, start, at);
    let ended = search.run();
    counts.iterations += search.iterations;
    counts.residuals += search.residual_evaluations;
    counts.jacobians += search.jacobian_evaluations;
    let Search { point, at, initial_cost, path, .. } = search;
    Ok(Found { point, at, initial_cost, path, ended })
}

struct Search<'a, P: Problem> {
    problem: &'a P,
    options: &'a Options,
    style: Style,
    point: P::Point,
    at: Linearised,
    initial_cost: f64,
    qr: Qr,
    /// `Qᵀ √w r`; its leading rows are the gradient in an orthonormal basis.
    rotated: DVector<f64>,
    scale: DVector<f64>,
    damping: f64,
    /// Factor by which the next rejection raises the damping (Nielsen 1999).
    growth: f64,
    step: DVector<f64>,
    path: DVector<f64>,
    /// Whether the cost has ceased to tell better from worse.
    polishing: bool,
    /// Where the search was before a step that the cost could not judge.
    before_polish: Option<Before<P::Point>>,
    iterations: usize,
    residual_evaluations: usize,
    jacobian_evaluations: usize,
    trial: Evaluated,
    tangent: DVector<f64>,
    predicted: DVector<f64>,
    bend: DVector<f64>,
}

struct Before<Point> {
    point: Point,
    evaluated: Evaluated,
    gradient: f64,
}

impl<'a, P: Problem> Search<'a, P> {
    fn new(
        problem: &'a P,
        options: &'a Options,
        style: Style,
        point: P::Point,
        at: Linearised,
    ) -> Self {
        let (rows, columns) = at.jacobian.shape();
        Self {
            problem,
            options,
            style,
            point,
            initial_cost: at.evaluated.cost,
            qr: Qr::new(rows, columns),
            rotated: DVector::zeros(rows.max(columns)),
            scale: DVector::zeros(columns),
            damping: style.initial_damping,
            growth: 2.0,
            step: DVector::zeros(columns),
            path: DVector::zeros(columns),
            polishing: false,
            before_polish: None,
            iterations: 0,
            residual_evaluations: 0,
            jacobian_evaluations: 0,
            trial: Evaluated::new(rows),
            tangent: DVector::zeros(at.tangent_dim()),
            predicted: DVector::zeros(rows),
            bend: DVector::zeros(rows.max(columns)),
            at,
        }
    }

    fn run(&mut self) -> Ended {
        loop {
            if let Some(ended) = self.linearise() {
                return ended;
            }
            if let Some(ended) = self.advance() {
                return ended;
            }
        }
    }

    /// Jacobian, factor and scale at the current point; the tests that need nothing else.
    fn linearise(&mut self) -> Option<Ended> {
        if let Err(non_finite) = self.differentiate() {
            return Some(Ended::NonFinite(non_finite));
        }
        self.factor();
        if let Some(before) = self.before_polish.take() {
            let gradient = self.gradient();
            if gradient.is_nan() || gradient > POLISH_RATE * before.gradient {
                return Some(self.end_polish(before));
            }
        }
        if self.at.gradient_correlation() <= self.options.gradient_tolerance {
            return Some(Ended::Converged(Termination::Gradient));
        }
        let promise = 0.5 * self.gradient().powi(2);
        if promise <= self.options.cost_tolerance * self.at.evaluated.cost || self.nothing_left() {
            return Some(Ended::Converged(Termination::Cost));
        }
        (self.iterations >= self.options.max_iterations).then_some(Ended::OutOfIterations)
    }

    fn differentiate(&mut self) -> Result<(), NonFinite> {
        self.jacobian_evaluations += 1;
        self.at.differentiate(self.problem, &self.point)
    }

    fn factor(&mut self) {
        self.qr.factor(&self.at.jacobian, &self.at.column_norms);
        let rows = self.at.weighted.len();
        self.rotated.rows_mut(0, rows).copy_from(&self.at.weighted);
        self.rotated.rows_range_mut(rows..).fill(0.0);
        self.qr.q_transpose_mul(&mut self.rotated);
        let memory = self.style.scale_memory;
        for (scale, &norm) in self.scale.iter_mut().zip(&self.at.column_norms) {
            *scale = f64::max(memory * *scale, norm);
            if *scale == 0.0 {
                *scale = 1.0;
            }
        }
    }

    /// Length of the residual's projection on the columns: what a full step would remove.
    fn gradient(&self) -> f64 {
        self.rotated.rows(0, self.step.len()).norm()
    }

    /// Whether the fit has become exact as far as numbers go, which its gradient never shows.
    fn nothing_left(&self) -> bool {
        let evaluated = &self.at.evaluated;
        evaluated.cost <= NOTHING_LEFT.powi(2) * self.initial_cost
            && evaluated.residuals.amax() < 1.0
    }

    /// Moves on: by the cost while that can tell, then by the gradient.
    fn advance(&mut self) -> Option<Ended> {
        let promise = 0.5 * self.gradient().powi(2);
        if !self.polishing && promise > COST_RESOLUTION * self.at.evaluated.cost {
            let ended = self.descend()?;
            if !matches!(ended, Ended::Converged(Termination::Cost)) {
                return Some(ended);
            }
        }
        self.polish()
    }

    /// Takes an undamped step that the cost cannot judge; the gradient will, in
    /// [`Search::linearise`]. Damping would only slow the last digits.
    fn polish(&mut self) -> Option<Ended> {
        self.polishing = true;
        self.damping = 0.0;
        if !self.solve_step() {
            return Some(Ended::Converged(Termination::Cost));
        }
        self.at.spread(&self.step, &mut self.tangent);
        let candidate = self.problem.retract(&self.point, &self.tangent);
        self.evaluate_trial(&candidate);
        let cost = self.at.evaluated.cost;
        let change = (cost - self.trial.cost).abs();
        if change.is_nan() || change > UNRESOLVED_CORRELATION * cost {
            return Some(Ended::Converged(Termination::Cost));
        }
        self.before_polish = Some(Before {
            point: self.point.clone(),
            evaluated: self.at.evaluated.clone(),
            gradient: self.gradient(),
        });
        self.move_to(candidate);
        None
    }

    /// Keeps the better of the last two points by their gradients.
    fn end_polish(&mut self, before: Before<P::Point>) -> Ended {
        if self.gradient() < before.gradient {
            return Ended::Converged(Termination::Cost);
        }
        self.point = before.point;
        self.at.evaluated = before.evaluated;
        match self.differentiate() {
            Ok(()) => Ended::Converged(Termination::Cost),
            Err(non_finite) => Ended::NonFinite(non_finite),
        }
    }
}
