//! One Levenberg-Marquardt search from one point.

use nalgebra::DVector;

use crate::linearised::{Evaluated, Linearised, NonFinite};
use crate::qr::Qr;
use crate::{Options, Problem, SolveError, Termination};

/// Share of the cost below which its rounding hides a decrease: the sum of some hundred squares
/// is good to about 1e-15.
const COST_RESOLUTION: f64 = 1e-14;
/// Actual over promised decrease from which a step is accepted.
const MIN_GAIN: f64 = 1e-4;
/// A polishing step has to shrink the gradient by this factor to be followed by another.
const POLISH_RATE: f64 = 0.9;
/// Gradient, in units of the residual's measured noise, that counts as nought.
const NOISE_FACTOR: f64 = 1e3;
/// Factor on a step that rounding swallows, to see whether the residuals follow at all.
const ENLARGEMENT: f64 = 1e4;
/// Correlation that the cost cannot resolve: the square root of [`COST_RESOLUTION`].
const UNRESOLVED_CORRELATION: f64 = 1e-7;
/// Damping after an undamped step is rejected.
const REDAMPING: f64 = 1e-12;
/// Damping at which a step has vanished beside any other.
const MAX_DAMPING: f64 = 1e60;
/// Share of the start's residual below which nothing is left to fit.
const NOTHING_LEFT: f64 = 1e-31;
/// Where along the step its curvature is measured, as a share of it (Transtrum 2012: 0.1).
const CURVATURE_PROBE: f64 = 0.1;
/// Largest acceleration over velocity for which the expansion is trusted (Transtrum 2012: 0.75).
const MAX_ACCELERATION: f64 = 0.75;

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

enum Trial {
    Accepted,
    /// With what the Jacobian leaves unexplained of the change, where that is a number.
    Rejected {
        unexplained: Option<f64>,
    },
    /// The residuals did not change at all: the step is below the resolution of the point.
    Unchanged,
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
        self.qr.factor(&self.at.jacobian);
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

    /// Tries ever shorter steps until one is accepted, or none can be.
    fn advance(&mut self) -> Option<Ended> {
        let promise = 0.5 * self.gradient().powi(2);
        let blind = promise <= COST_RESOLUTION * self.at.evaluated.cost;
        let mut noise = None;
        let mut undamped_next = true;
        while self.damping <= MAX_DAMPING {
            self.qr.solve_damped(&self.rotated, self.damping, &self.scale, &mut self.step);
            if self.step.iter().all(|s| s.is_finite()) {
                if self.step_is_negligible() {
                    return Some(Ended::Converged(Termination::Step));
                }
                match self.try_step(blind) {
                    Trial::Accepted => return None,
                    Trial::Rejected { unexplained } => noise = unexplained.or(noise),
                    Trial::Unchanged if noise.is_some() || self.damping == 0.0 => break,
                    // Not even the first step was felt: see what the longest one does.
                    Trial::Unchanged if undamped_next => {
                        undamped_next = false;
                        self.damping = 0.0;
                        continue;
                    }
                    Trial::Unchanged => {}
                }
            }
            self.damping = if self.damping > 0.0 { self.damping * self.growth } else { REDAMPING };
            self.growth *= 2.0;
        }
        let converged = self.at.gradient_correlation() <= UNRESOLVED_CORRELATION
            || match noise {
                Some(noise) => self.gradient() <= NOISE_FACTOR * noise,
                None => self.is_below_resolution(),
            };
        Some(if converged { Ended::Converged(Termination::Cost) } else { Ended::Stalled })
    }

    /// Whether residuals that do not feel the last step do follow one that is longer.
    fn is_below_resolution(&mut self) -> bool {
        self.step *= ENLARGEMENT;
        self.predicted.gemv(1.0, &self.at.jacobian, &self.step, 0.0);
        self.at.spread(&self.step, &mut self.tangent);
        let enlarged = self.problem.retract(&self.point, &self.tangent);
        self.evaluate_trial(&enlarged);
        self.unexplained() <= 0.5 * self.predicted.norm()
    }

    /// Whether the step, and the undamped one too, is lost in the way already come.
    fn step_is_negligible(&mut self) -> bool {
        let tolerance = self.options.step_tolerance;
        let path = &self.path;
        let negligible = |step: &DVector<f64>| {
            step.iter().zip(path).all(|(s, p)| s.abs() <= tolerance * p.abs())
        };
        if !negligible(&self.step) {
            return false;
        }
        let mut undamped = self.step.clone();
        self.qr.solve_damped(&self.rotated, 0.0, &self.scale, &mut undamped);
        negligible(&undamped)
    }

    fn try_step(&mut self, blind: bool) -> Trial {
        self.predicted.gemv(1.0, &self.at.jacobian, &self.step, 0.0);
        let scaled = self.step.component_mul(&self.scale).norm_squared();
        let promise = 0.5 * self.predicted.norm_squared() + self.damping * scaled;
        if self.style.accelerate && !blind && !self.accelerate() {
            return Trial::Rejected { unexplained: None };
        }
        self.at.spread(&self.step, &mut self.tangent);
        let candidate = self.problem.retract(&self.point, &self.tangent);
        self.evaluate_trial(&candidate);

        let cost = self.at.evaluated.cost;
        let decrease = cost - self.trial.cost;
        if blind && decrease.abs() <= UNRESOLVED_CORRELATION * cost {
            self.polish_to(candidate);
            return Trial::Accepted;
        }
        if decrease > 0.0 && decrease > MIN_GAIN * promise {
            self.move_to(candidate);
            let gain = decrease / promise;
            self.damping *= f64::max(self.style.relief, 1.0 - (2.0 * gain - 1.0).powi(3));
            self.growth = 2.0;
            return Trial::Accepted;
        }
        if self.trial.residuals == self.at.evaluated.residuals {
            return Trial::Unchanged;
        }
        Trial::Rejected { unexplained: self.trial.cost.is_finite().then(|| self.unexplained()) }
    }

    fn evaluate_trial(&mut self, candidate: &P::Point) {
        self.residual_evaluations += 1;
        self.trial.fill(self.problem, candidate, self.options);
    }

    fn move_to(&mut self, candidate: P::Point) {
        self.path += &self.step;
        self.point = candidate;
        std::mem::swap(&mut self.at.evaluated, &mut self.trial);
        self.iterations += 1;
    }

    /// Moves where the cost cannot judge; the gradient will, in [`Search::linearise`].
    fn polish_to(&mut self, candidate: P::Point) {
        self.before_polish = Some(Before {
            point: self.point.clone(),
            evaluated: self.at.evaluated.clone(),
            gradient: self.gradient(),
        });
        self.move_to(candidate);
        self.damping = 0.0;
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

    /// Change of the residuals at the trial that the Jacobian does not predict.
    ///
    /// For a short step this is the rounding noise of the residuals.
    fn unexplained(&self) -> f64 {
        let (now, then) = (&self.trial.residuals, &self.at.evaluated.residuals);
        let rows = now.iter().zip(then).zip(&self.at.evaluated.root_weights).zip(&self.predicted);
        rows.map(|(((n, t), w), p)| (w * (n - t) - p).powi(2)).sum::<f64>().sqrt()
    }

    /// Adds half the acceleration along the model's curvature (Transtrum and Sethna 2012).
    ///
    /// False where the curvature is too strong for the step to be trusted.
    fn accelerate(&mut self) -> bool {
        self.at.spread(&(&self.step * CURVATURE_PROBE), &mut self.tangent);
        let probe = self.problem.retract(&self.point, &self.tangent);
        self.evaluate_trial(&probe);
        let (now, then) = (&self.trial.residuals, &self.at.evaluated.residuals);
        let weights = &self.at.evaluated.root_weights;
        self.bend.fill(0.0);
        for row in 0..now.len() {
            let slope = weights[row] * (now[row] - then[row]) / CURVATURE_PROBE;
            self.bend[row] = 2.0 / CURVATURE_PROBE * (slope - self.predicted[row]);
        }
        if self.bend.iter().any(|b| !b.is_finite()) {
            return false;
        }
        self.qr.q_transpose_mul(&mut self.bend);
        let mut acceleration = self.step.clone();
        self.qr.solve_damped(&self.bend, self.damping, &self.scale, &mut acceleration);
        let length = |v: &DVector<f64>| v.component_mul(&self.scale).norm();
        if length(&acceleration) > MAX_ACCELERATION * length(&self.step) {
            return false;
        }
        self.step.axpy(0.5, &acceleration, 1.0);
        true
    }
}
