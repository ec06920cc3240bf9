//! The iteration: find what is nearest, solve for the motion, move.

use nalgebra::{Isometry3, Point3, Vector6};

use super::averages::Averages;
use super::chart::{self, Chart};
use super::error::RegisterError;
use super::information::Information;
use super::motions::Motions;
use super::moving::Moving;
use super::options::{Objective, RegisterOptions};
use super::pass::{self, Rules};
use super::point_cloud::PointCloud;
use super::registration::Termination;
use super::sums::Sums;
use super::target::{Target, Wanted};

/// Share of the target's spacing up to which leads are looked for: a pass near the end moves less.
const MARGIN_SPACINGS: f64 = 0.05;

/// A coarse level ends when a pass moves the pose by less than this share of its own standard
/// uncertainty: that of the next finer level is a quarter of it.
const COARSE_SHARE: f64 = 0.1;

/// Passes without a smaller motion after which points are taken to change their minds for ever.
const PATIENCE: usize = 5;

/// Share of the tolerance that the next motion must be foretold to stay below.
const FORETOLD_SHARE: f64 = 0.1;

/// Share of the pose's own standard uncertainty that such a motion may have.
const SETTLED_SHARE: f64 = 0.1;

/// Largest rotation of one step; beyond it the small-angle rows mean nothing.
const MAX_STEP_RAD: f64 = 0.5;

/// Median of |r| over the standard deviation of a normal variable.
const MEDIAN_OF_ONE: f64 = 0.674_489_750_196_081_7;

/// The same for the length of a vector of three.
const MEDIAN_OF_THREE: f64 = 1.538_172_254_455_203_6;

/// What stays the same during a search.
pub(super) struct Search<'a, T> {
    pub(super) target: &'a T,
    pub(super) has_normals: bool,
    pub(super) options: &'a RegisterOptions,
    pub(super) chart: Chart,
    pub(super) arm_mm: f64,
    pub(super) wanted: Wanted,
}

/// How far the search came.
#[derive(Clone)]
pub(super) struct State {
    pub(super) xi: Vector6<f64>,
    pub(super) pose: Isometry3<f64>,
    /// Scale of the robust loss, once it is settled.
    pub(super) scale_mm: Option<f64>,
    pub(super) iterations: usize,
    pub(super) motion_mm: f64,
    /// The same in standard uncertainties of the pose, in quadratic mean over its directions.
    pub(super) motion_sigmas: f64,
}

/// What a pass found out.
pub(super) struct Pass<'a> {
    pub(super) sums: Sums,
    pub(super) rules: Rules<'a>,
    pub(super) sigma_mm: f64,
}

impl<'s, T: Target> Search<'s, T> {
    pub(super) fn new(
        source: &PointCloud,
        target: &'s T,
        has_normals: bool,
        options: &'s RegisterOptions,
    ) -> Result<Self, RegisterError> {
        let centroid = centroid(&source.points_mm);
        let pivot = options.pivot_mm.unwrap_or_else(|| options.start * centroid);
        let chart = Chart::new(options, pivot);
        if source.points_mm.len() < chart.free.len() {
            let (got, unknowns) = (source.points_mm.len(), chart.free.len());
            return Err(RegisterError::TooFewPoints { got, unknowns });
        }
        let arm_mm = arm(&source.points_mm, &(options.start.inverse() * pivot));
        let wanted = Wanted {
            limit_mm: options.max_distance_mm.unwrap_or(f64::INFINITY),
            margin_mm: MARGIN_SPACINGS * target.spacing_mm(),
            skip_beside: options.skip_beyond_border && has_normals,
        };
        Ok(Self { target, has_normals, options, chart, arm_mm, wanted })
    }

    pub(super) fn at_start(&self) -> State {
        State {
            xi: Vector6::zeros(),
            pose: self.chart.pose(&Vector6::zeros()),
            scale_mm: self.options.sigma_mm,
            iterations: 0,
            motion_mm: f64::INFINITY,
            motion_sigmas: f64::INFINITY,
        }
    }

    /// Passes over one level until they move nothing any more.
    pub(super) fn settle<'a>(
        &self,
        level: &mut Moving,
        state: &mut State,
        is_last: bool,
        averages: Option<&'a Averages>,
    ) -> Result<(Pass<'a>, Option<Termination>), RegisterError> {
        let mut motions = Motions::default();
        for n in 1.. {
            let pass = self.pass(level, state, averages)?;
            self.step(level, state, &pass, motions.waited >= PATIENCE);
            motions.add(state.motion_mm, state.motion_sigmas);
            if is_last && state.motion_mm < pass.rules.sigma_mm {
                state.scale_mm = Some(pass.rules.sigma_mm);
            }
            let ended = if is_last {
                self.ended(&motions)
            } else {
                let is_enough = motions.last_mm <= self.options.tolerance_mm
                    || motions.last_sigmas <= COARSE_SHARE
                    || motions.waited >= PATIENCE
                    || self.is_restless(&motions, 1.0);
                is_enough.then_some(Termination::Motion)
            };
            if ended.is_some() || n >= self.options.max_iterations {
                return Ok((pass, ended));
            }
        }
        unreachable!("the loop ends by returning")
    }

    /// Whether the passes over all points have come to an end.
    fn ended(&self, motions: &Motions) -> Option<Termination> {
        let tolerance_mm = self.options.tolerance_mm;
        let is_still = motions.last_mm <= tolerance_mm
            || motions.next_mm().is_some_and(|next| next <= FORETOLD_SHARE * tolerance_mm);
        if is_still {
            return Some(Termination::Motion);
        }
        let is_settled = motions.waited >= PATIENCE && motions.last_sigmas <= SETTLED_SHARE
            || self.is_restless(motions, SETTLED_SHARE);
        is_settled.then_some(Termination::Settled)
    }

    /// Whether motions of at most this have stopped to become smaller.
    ///
    /// Only rows along normals say so at once: those between points creep, by motions that hardly
    /// become smaller either.
    fn is_restless(&self, motions: &Motions, at_most_sigmas: f64) -> bool {
        self.options.objective != Objective::PointToPoint && motions.are_restless(at_most_sigmas)
    }

    fn pass<'a>(
        &self,
        level: &mut Moving,
        state: &mut State,
        averages: Option<&'a Averages>,
    ) -> Result<Pass<'a>, RegisterError> {
        pass::find(level, self.target, &state.pose, &self.wanted);
        let rules = self.rules(level, state, averages);
        let sums = pass::sum(level, self.target, &state.pose, &rules);
        let unknowns = self.chart.free.len();
        if sums.n_used < unknowns.max(1) {
            let (used, points) = (sums.n_used, level.points.len());
            let max_distance_mm = self.options.max_distance_mm;
            return Err(RegisterError::NoOverlap { used, points, max_distance_mm });
        }
        let sigma_mm = self.options.sigma_mm.unwrap_or_else(|| spread_mm(&sums, unknowns));
        Ok(Pass { sums, rules, sigma_mm })
    }

    fn rules<'a>(
        &self,
        level: &Moving,
        state: &State,
        averages: Option<&'a Averages>,
    ) -> Rules<'a> {
        let options = self.options;
        let mut rules = Rules {
            objective: options.objective,
            pivot: self.chart.pivot,
            skip_beside: self.wanted.skip_beside,
            limit_mm: self.wanted.limit_mm,
            keep_below_mm2: f64::INFINITY,
            loss: options.loss,
            sigma_mm: state.scale_mm.unwrap_or(1.0),
            averages,
        };
        let needs_scale = options.loss.is_some() && state.scale_mm.is_none();
        if needs_scale || options.keep_share < 1.0 {
            let mut squared = pass::squared_residuals(level, self.target, &state.pose, &rules);
            if needs_scale {
                let median = quantile(&mut squared, 0.5).sqrt();
                let factor = match options.objective {
                    Objective::PointToPoint => MEDIAN_OF_THREE,
                    Objective::PointToPlane | Objective::Symmetric => MEDIAN_OF_ONE,
                };
                // Points that fit exactly still need a scale.
                rules.sigma_mm = (median / factor).max(options.tolerance_mm);
            }
            if options.keep_share < 1.0 {
                rules.keep_below_mm2 = quantile(&mut squared, options.keep_share);
            }
        }
        rules
    }

    /// Solves for the motion and moves: all the way, or half of it where points change their minds for
    /// ever, which ends between the poses that they lead to.
    fn step(&self, level: &Moving, state: &mut State, pass: &Pass, is_half: bool) {
        let (mut hessian, mut gradient) =
            chart::pulled_back(&state.xi, &pass.sums.hessian, &pass.sums.gradient);
        self.chart.add_priors(&state.xi, pass.sigma_mm, &mut hessian, &mut gradient);
        let information = Information::new(&hessian, &self.chart.free, self.arm_mm);
        let mut step = information.step(&gradient);
        // What the step gains in Σ w r² is its length in the metric of the normal equations.
        let squared = -step.dot(&gradient) / as_f64(self.chart.free.len().max(1));
        state.motion_sigmas = squared.max(0.0).sqrt() / pass.sigma_mm;
        let turn_rad = step.fixed_rows::<3>(3).norm();
        if turn_rad > MAX_STEP_RAD {
            step *= MAX_STEP_RAD / turn_rad;
        }
        state.motion_mm = level.motion_mm(&state.pose, &self.chart.pose(&(state.xi + step)));
        state.xi += if is_half { 0.5 * step } else { step };
        state.pose = self.chart.pose(&state.xi);
        state.iterations += 1;
    }
}

fn spread_mm(sums: &Sums, unknowns: usize) -> f64 {
    let freedom = sums.n_rows.saturating_sub(unknowns).max(1);
    (sums.squares_mm2 / as_f64(freedom)).sqrt()
}

/// Root-mean-square residual of the points used.
pub(super) fn rms_mm(sums: &Sums) -> f64 {
    (sums.squares_mm2 / as_f64(sums.n_used)).sqrt()
}

#[expect(clippy::cast_precision_loss, reason = "point counts are far below 2^53")]
pub(super) fn as_f64(count: usize) -> f64 {
    count as f64
}

/// Value below which a share of the values lies; 0 for none.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a share of a count"
    )]
    let rank = (share * as_f64(values.len())).ceil() as usize;
    let at = rank.clamp(1, values.len()) - 1;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

fn centroid(points: &[Point3<f64>]) -> Point3<f64> {
    let sum = points.iter().fold(nalgebra::Vector3::zeros(), |sum, p| sum + p.coords);
    Point3::from(sum / as_f64(points.len()))
}

/// Root-mean-square distance of the points from the pivot.
fn arm(points: &[Point3<f64>], pivot: &Point3<f64>) -> f64 {
    let squares: f64 = points.iter().map(|p| (p - pivot).norm_squared()).sum();
    let arm = (squares / as_f64(points.len())).sqrt();
    if arm > 0.0 { arm } else { 1.0 }
}
