//! The Levenberg-Marquardt search over shared point and blocks.

use super::passes::{Room, Setting};
use super::reduced::Reduced;
use super::trial::Gain;
use super::{BorderedOptions, BorderedPoint, BorderedProblem};
use crate::Termination;

/// Actual over promised decrease from which a step is accepted.
const MIN_GAIN: f64 = 1e-4;
/// Least factor on the damping after a step that went as promised.
const RELIEF: f64 = 1e-3;
/// Damping below which it is nought: beside rounding it changes no step.
const NEGLIGIBLE_DAMPING: f64 = 1e-13;
/// Damping up to which a step counts as full.
const FULL_STEP: f64 = 1e-6;
/// Damping at least after a rejected step: less would not change it.
const REDAMPING: f64 = 1e-4;
/// Factor on the damping after the first rejection; it squares with each further one.
const GROWTH: f64 = 10.0;
/// Damping at which a step has vanished beside any other.
const MAX_DAMPING: f64 = 1e12;
/// Share of a diagonal entry, in units of the damping, that the damping may have left.
const DAMPED: f64 = 100.0;
/// Gradient, in units of the residual's measured rounding, that counts as nought.
const NOISE_FACTOR: f64 = 1e3;
/// Damping from which a step is short enough to see the residual's rounding beside it.
const SHORT_STEP: f64 = 1.0;
/// Growth, over a full step, of what a short step leaves unexplained in units of what it moves,
/// from which that is rounding: curvature makes it fall, a wrong derivative keeps it.
const ROUGHER: f64 = 10.0;
/// Share of what a full step leaves unexplained that rounding has to account for.
const ACCOUNTS_FOR: f64 = 1e-3;
/// Share of a step, in what it moves, that has to move something where numbers can show it: one
/// that does not leaves the whole below 1e-11 of the numbers.
const SEEN_SHARE: f64 = 1e-5;
/// Share of the cost below which its rounding hides a change.
const COST_RESOLUTION: f64 = 1e-14;
/// Share of the start's residual below which nothing is left to fit.
const NOTHING_LEFT: f64 = 1e-28;

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Ended {
    Converged(Termination),
    /// No step lowers the cost although the derivatives promise it.
    Stalled,
    OutOfIterations,
    /// The cost or a derivative is not finite where the search stands.
    NonFinite,
}

/// A step that was not taken.
#[derive(Clone, Copy)]
struct Rejected {
    /// Of the cost, either way.
    change: f64,
    /// `|J δ|²`
    moved: f64,
    /// `|r_new − r − J δ|²`
    unexplained: f64,
}

impl Rejected {
    /// Whether this short step shows that rounding hides what the first, longer one promised: it
    /// shakes the residual by more than it moves it, or not at all.
    fn is_below_rounding(&self, first: &Self, cost: f64) -> bool {
        let is_hidden = first.moved <= 2.0 * first.unexplained;
        let roughness = |step: &Self| step.unexplained / step.moved;
        // Rounding shakes in proportion to the step's length; what it does here has to account
        // for what the first step missed.
        let length = (self.moved / first.moved).sqrt();
        let accounts = self.unexplained >= ACCOUNTS_FOR * length * first.unexplained;
        let is_rough = accounts && roughness(self) >= ROUGHER * roughness(first).max(1.0);
        let is_seen = self.moved >= SEEN_SHARE.powi(2) * first.moved;
        let resolution = COST_RESOLUTION * cost;
        let has_vanished = is_seen && self.change <= resolution && first.change > resolution;
        is_hidden && (is_rough || has_vanished)
    }
}

pub(super) struct Search<'a, P> {
    setting: Setting<'a, P>,
    options: &'a BorderedOptions,
    room: Room,
    reduced: Reduced,
    pub(super) point: BorderedPoint,
    trial: BorderedPoint,
    /// Room for the shared rows of a trial.
    trial_rows: (Vec<f64>, Vec<f64>),
    damping: f64,
    /// Damping of the last elimination.
    eliminated_damping: f64,
    /// Squared length of all steps, in lengths of the columns.
    path: f64,
    pub(super) initial_cost: f64,
    pub(super) cost: f64,
    /// Correlation of the residual with all columns together.
    pub(super) gradient: f64,
    pub(super) iterations: usize,
    pub(super) residual_evaluations: usize,
    pub(super) jacobian_evaluations: usize,
}

impl<'a, P: BorderedProblem> Search<'a, P> {
    pub(super) fn new(
        setting: Setting<'a, P>,
        options: &'a BorderedOptions,
        point: BorderedPoint,
    ) -> Self {
        let shared_rows = setting.problem.shared_residual_count();
        let numbers = shared_rows * setting.program.shared_dim;
        let damping = options.initial_damping;
        Self {
            room: Room::new(setting.program),
            reduced: Reduced::new(setting.program, shared_rows),
            trial: point.clone(),
            trial_rows: (vec![0.0; shared_rows], vec![0.0; numbers]),
            damping: if damping.is_finite() { damping.max(0.0) } else { 0.0 },
            eliminated_damping: 0.0,
            path: 0.0,
            initial_cost: 0.0,
            cost: 0.0,
            gradient: 0.0,
            iterations: 0,
            residual_evaluations: 0,
            jacobian_evaluations: 0,
            setting,
            options,
            point,
        }
    }

    pub(super) fn run(&mut self) -> Ended {
        self.linearise();
        (self.cost, self.initial_cost) = (self.linearised_cost(), self.linearised_cost());
        loop {
            if !self.cost.is_finite() || !self.reduced.promised.is_finite() {
                return Ended::NonFinite;
            }
            if let Some(termination) = self.has_converged() {
                self.polish();
                return Ended::Converged(termination);
            }
            if self.iterations >= self.options.max_iterations {
                return Ended::OutOfIterations;
            }
            if let Some(ended) = self.descend() {
                return ended;
            }
            self.linearise();
        }
    }

    /// Least share of a diagonal entry that the elimination leaves; nought where that may be the
    /// damping's doing.
    pub(super) fn least_pivot(&self) -> f64 {
        let blocks = self.room.sums.least_pivot;
        let least = blocks.min(self.reduced.least_pivot);
        if least > DAMPED * self.eliminated_damping { least } else { 0.0 }
    }

    /// Columns, elimination and the step for the present damping.
    fn linearise(&mut self) {
        let program = self.setting.program;
        self.jacobian_evaluations += 1;
        self.eliminated_damping = self.damping;
        self.setting.eliminate(&mut self.room, &self.point, self.damping);
        let sums = &self.room.sums;
        self.reduced.collect(self.setting.problem, program, &self.point.shared, sums);
        self.reduced.solve(program, self.damping);
        self.gradient = (self.reduced.promised / self.reduced.twice_cost).sqrt().min(1.0);
        if self.reduced.twice_cost == 0.0 {
            self.gradient = 0.0;
        }
    }

    fn linearised_cost(&self) -> f64 {
        0.5 * self.reduced.twice_cost
    }

    /// The tests that need no step.
    fn has_converged(&self) -> Option<Termination> {
        let promise = 0.5 * self.reduced.promised;
        let is_full = self.damping <= FULL_STEP;
        if is_full && promise <= self.options.cost_tolerance * self.cost {
            return Some(Termination::Gradient);
        }
        (self.cost <= NOTHING_LEFT * self.initial_cost).then_some(Termination::Cost)
    }

    /// Takes a last step that promises next to nothing, unless rounding makes it worse: it
    /// squares what is left of the way to the minimum.
    fn polish(&mut self) {
        if self.reduced.promised > f64::EPSILON.powi(2) * self.cost {
            let gain = self.try_step();
            let cost = 0.5 * gain.twice_cost;
            if cost <= (1.0 + self.options.cost_tolerance.max(0.0)) * self.cost {
                self.note_gradient(cost, &gain);
                std::mem::swap(&mut self.point, &mut self.trial);
                self.cost = cost;
            }
        }
    }

    /// Takes a step that lowers the cost, or says why there is none.
    fn descend(&mut self) -> Option<Ended> {
        let ended = self.shorten(f64::INFINITY);
        if ended != Some(Ended::Stalled) {
            return ended;
        }
        // Once more from a full step on and decade by decade: only beside a full step, and not
        // too far from it, does a short one show what rounding does.
        self.damping = 0.0;
        self.linearise();
        self.shorten(GROWTH)
    }

    /// Tries ever shorter steps until one is accepted, or none can be; the damping grows by at
    /// most the given factor at a time.
    fn shorten(&mut self, most: f64) -> Option<Ended> {
        let promised = self.reduced.promised;
        let mut growth = GROWTH;
        let from_full = self.damping <= FULL_STEP;
        let mut first = None;
        loop {
            let gain = self.try_step();
            let promise = self.promise(&gain);
            let scaled_step = self.scaled_step(&gain);
            let cost = 0.5 * gain.twice_cost;
            let decrease = self.cost - cost;
            let is_full = self.damping <= FULL_STEP;
            if cost.is_finite() && decrease > 0.0 && decrease > MIN_GAIN * promise {
                let as_promised = (decrease - promise).abs() <= self.options.cost_tolerance * cost;
                self.note_gradient(cost, &gain);
                self.accept(cost, decrease / promise, scaled_step);
                return (is_full && as_promised).then_some(Ended::Converged(Termination::Cost));
            }
            let tolerance = self.options.step_tolerance;
            if is_full && scaled_step.sqrt() <= tolerance * self.path.sqrt() {
                return Some(Ended::Converged(Termination::Step));
            }
            let moved = self.damping.mul_add(-scaled_step, self.reduced.promised);
            let rejected =
                Rejected { change: decrease.abs(), moved, unexplained: gain.unexplained };
            let first = first.get_or_insert(rejected);
            let is_short = from_full && self.damping >= SHORT_STEP;
            if is_short && rejected.is_below_rounding(first, self.cost) {
                return Some(Ended::Converged(Termination::Cost));
            }
            if self.damping >= MAX_DAMPING {
                let is_noise = promised <= NOISE_FACTOR.powi(2) * gain.unexplained;
                return Some(if is_noise {
                    Ended::Converged(Termination::Cost)
                } else {
                    Ended::Stalled
                });
            }
            self.damping = (self.damping * growth).max(REDAMPING);
            growth = (growth * growth).min(most);
            self.linearise();
        }
    }

    /// Evaluates the present step in `trial`.
    fn try_step(&mut self) -> Gain {
        self.residual_evaluations += 1;
        let Self { setting, room, reduced, point, trial, trial_rows, .. } = self;
        setting.problem.retract_shared(&point.shared, &reduced.tangent, &mut trial.shared);
        let mut gain = setting.step(room, point, &reduced.step, self.damping, trial);
        let (residuals, jacobian) = trial_rows;
        let (squares, unexplained) =
            reduced.try_shared_rows(setting.problem, &trial.shared, residuals, jacobian);
        gain.twice_cost += squares;
        gain.unexplained += unexplained;
        gain
    }

    fn scaled_step(&self, gain: &Gain) -> f64 {
        let Reduced { diagonal, step, .. } = &self.reduced;
        let shared = diagonal.iter().zip(&step[1..]).map(|(d, s)| d * s * s);
        gain.scaled_step + shared.sum::<f64>()
    }

    /// Decrease of the cost that the derivatives promise for the damped step.
    fn promise(&self, gain: &Gain) -> f64 {
        0.5 * self.damping.mul_add(self.scaled_step(gain), self.reduced.promised)
    }

    /// What a step leaves to do, judged by how far the cost misses what was promised.
    fn note_gradient(&mut self, cost: f64, gain: &Gain) {
        let missed = (self.cost - cost - self.promise(gain)).abs();
        self.gradient = if missed == 0.0 { 0.0 } else { (missed / cost).sqrt().min(1.0) };
    }

    fn accept(&mut self, cost: f64, gain: f64, scaled_step: f64) {
        std::mem::swap(&mut self.point, &mut self.trial);
        self.cost = cost;
        self.path += scaled_step;
        self.iterations += 1;
        self.damping *= f64::max(RELIEF, 1.0 - (2.0 * gain - 1.0).powi(3));
        if self.damping < NEGLIGIBLE_DAMPING {
            self.damping = 0.0;
        }
    }
}
