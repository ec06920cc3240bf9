//! Steps whose success the cost can judge.

use nalgebra::DVector;

use super::{Ended, Search, UNRESOLVED_CORRELATION};
use crate::{Problem, Termination};

/// Actual over promised decrease from which a step is accepted.
const MIN_GAIN: f64 = 1e-4;
/// Gradient, in units of the residual's measured noise, that counts as nought.
const NOISE_FACTOR: f64 = 1e3;
/// Factor on a step that rounding swallows, to see whether the residuals follow at all.
const ENLARGEMENT: f64 = 1e4;
/// A step that is short enough beside the full one to tell rounding from what goes with the step.
const SHORT_STEP: f64 = 1.0 / 16.0;
/// Share of what the full step leaves unexplained that a short one leaves where both are rounding:
/// well above the sixteenth of a wrong derivative, well below what chance makes of equals.
const SAME_ROUNDING: f64 = 0.25;
/// Damping after an undamped step is rejected.
const REDAMPING: f64 = 1e-12;
/// Damping at which a step has vanished beside any other.
const MAX_DAMPING: f64 = 1e60;
/// Where along the step its curvature is measured, as a share of it (Transtrum 2012: 0.1).
const CURVATURE_PROBE: f64 = 0.1;
/// Largest acceleration over velocity for which the expansion is trusted (Transtrum 2012: 0.75).
const MAX_ACCELERATION: f64 = 0.75;

enum Trial {
    Accepted,
    /// With what the Jacobian leaves unexplained of the change, where that is a number.
    Rejected {
        unexplained: Option<f64>,
    },
    /// The residuals did not change at all: the step is below the resolution of the point.
    Unchanged,
}

impl<P: Problem> Search<'_, P> {
    /// Tries ever shorter steps until one is accepted, or none can be.
    pub(super) fn descend(&mut self) -> Option<Ended> {
        let mut noise = None;
        let mut undamped_next = true;
        while self.damping <= MAX_DAMPING {
            if self.solve_step() {
                if self.step_is_negligible() {
                    return Some(Ended::Converged(Termination::Step));
                }
                match self.try_step() {
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
                Some(last) => {
                    // The last step tried may have changed no more than one digit of one row.
                    let noise = last.max(self.rounding());
                    // Rounding of the residuals changes the cost by up to noise · ‖r‖, the full
                    // step by half the square of the gradient.
                    let hidden = (2.0 * noise * self.at.weighted.norm()).sqrt();
                    self.gradient() <= hidden.max(NOISE_FACTOR * noise)
                }
                None => self.is_below_resolution(),
            };
        Some(if converged { Ended::Converged(Termination::Cost) } else { Ended::Stalled })
    }

    /// The step for the present damping; false where it is not finite.
    pub(super) fn solve_step(&mut self) -> bool {
        self.qr.solve_damped(&self.rotated, self.damping, &self.scale, &mut self.step);
        self.step.iter().all(|s| s.is_finite())
    }

    /// What the full step and a short one leave unexplained alike: rounding of the residuals.
    ///
    /// Zero where it shrinks with the step, as a wrong derivative and a curvature make it.
    fn rounding(&mut self) -> f64 {
        self.damping = 0.0;
        if !self.solve_step() {
            return 0.0;
        }
        let whole = self.unexplained_by_step();
        self.step *= SHORT_STEP;
        let short = self.unexplained_by_step();
        let is_constant = short.is_finite() && short > SAME_ROUNDING * whole;
        if is_constant { short } else { 0.0 }
    }

    /// What the present step leaves unexplained.
    fn unexplained_by_step(&mut self) -> f64 {
        self.predicted.gemv(1.0, &self.at.jacobian, &self.step, 0.0);
        self.at.spread(&self.step, &mut self.tangent);
        let moved = self.problem.retract(&self.point, &self.tangent);
        self.evaluate_trial(&moved);
        self.unexplained()
    }

    /// Whether residuals that do not feel the last step do follow one that is longer.
    fn is_below_resolution(&mut self) -> bool {
        self.step *= ENLARGEMENT;
        self.unexplained_by_step() <= 0.5 * self.predicted.norm()
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

    fn try_step(&mut self) -> Trial {
        self.predicted.gemv(1.0, &self.at.jacobian, &self.step, 0.0);
        let scaled = self.step.component_mul(&self.scale).norm_squared();
        let promise = 0.5 * self.predicted.norm_squared() + self.damping * scaled;
        if self.style.accelerate && !self.accelerate() {
            return Trial::Rejected { unexplained: None };
        }
        self.at.spread(&self.step, &mut self.tangent);
        let candidate = self.problem.retract(&self.point, &self.tangent);
        self.evaluate_trial(&candidate);

        let cost = self.at.evaluated.cost;
        let decrease = cost - self.trial.cost;
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

    pub(super) fn evaluate_trial(&mut self, candidate: &P::Point) {
        self.residual_evaluations += 1;
        self.trial.fill(self.problem, candidate, self.options);
    }

    pub(super) fn move_to(&mut self, candidate: P::Point) {
        self.path += &self.step;
        self.point = candidate;
        std::mem::swap(&mut self.at.evaluated, &mut self.trial);
        self.iterations += 1;
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
