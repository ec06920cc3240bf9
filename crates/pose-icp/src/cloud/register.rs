//! The iteration: find what is nearest, solve for the motion, move.

use nalgebra::{Isometry3, Point3, Vector6};

use super::averages::Averages;
use super::chart::{self, Chart};
use super::error::{RegisterError, Side};
use super::information::Information;
use super::motions::Motions;
use super::moving::Moving;
use super::observability::{Observability, WeakDirection};
use super::options::{Objective, RegisterOptions};
use super::pass::{self, Rules};
use super::point_cloud::PointCloud;
use super::registration::{Registration, Termination};
use super::sums::Sums;
use super::target::{CloudTarget, Target, Wanted};

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

/// Moves a cloud onto another.
///
/// Repeats: take the nearest target point of each source point, solve the linearised problem, move
/// (Chen and Medioni 1991), first with few source points, then with ever more
/// of them. A point keeps its nearest unasked while it provably stays nearest. Runs on the threads
/// of the surrounding rayon pool; the result has the same bits on any number of them.
///
/// # Errors
///
/// Whatever makes input or options unusable; [`RegisterError::NoOverlap`];
/// [`RegisterError::Undetermined`] where the shape leaves a motion free;
/// [`RegisterError::NotConverged`], which holds what was reached.
pub fn register_to_cloud(
    source: &PointCloud,
    target: &CloudTarget,
    options: &RegisterOptions,
) -> Result<Registration, RegisterError> {
    let needs_normals = options.objective != Objective::PointToPoint;
    if needs_normals && !target.has_normals() {
        return Err(RegisterError::MissingNormals { side: Side::Target });
    }
    register(source, target, target.has_normals(), options)
}

pub(crate) fn register<T: Target>(
    source: &PointCloud,
    target: &T,
    has_normals: bool,
    options: &RegisterOptions,
) -> Result<Registration, RegisterError> {
    source.check(Side::Source)?;
    options.check()?;
    if options.objective == Objective::Symmetric && source.normals.is_none() {
        return Err(RegisterError::MissingNormals { side: Side::Source });
    }
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
    let search = Search { target, has_normals, options, chart, arm_mm, wanted };
    search.run(Moving::levels(source))
}

struct Search<'a, T> {
    target: &'a T,
    has_normals: bool,
    options: &'a RegisterOptions,
    chart: Chart,
    arm_mm: f64,
    wanted: Wanted,
}

/// How far the search came.
struct State {
    xi: Vector6<f64>,
    pose: Isometry3<f64>,
    /// Pose at which the nearest points of this level were last found.
    found_at: Isometry3<f64>,
    /// Scale of the robust loss, once it is settled.
    scale_mm: Option<f64>,
    iterations: usize,
    motion_mm: f64,
    /// The same in standard uncertainties of the pose, in quadratic mean over its directions.
    motion_sigmas: f64,
}

/// What a pass found out.
struct Pass<'a> {
    sums: Sums,
    rules: Rules<'a>,
    sigma_mm: f64,
}

impl<T: Target> Search<'_, T> {
    fn run(&self, mut levels: Vec<Moving>) -> Result<Registration, RegisterError> {
        let start = self.chart.pose(&Vector6::zeros());
        let mut state = State {
            xi: Vector6::zeros(),
            pose: start,
            found_at: start,
            scale_mm: self.options.sigma_mm,
            iterations: 0,
            motion_mm: f64::INFINITY,
            motion_sigmas: f64::INFINITY,
        };
        let (finest, coarse) = levels.split_last_mut().expect("the finest level is there");
        let mut averages = None;
        for level in &mut *coarse {
            let (pass, _) = self.settle(level, &mut state, false, None)?;
            averages = self.averages(&pass);
        }
        let before = state.iterations;
        if coarse.is_empty() {
            let (pass, termination) = self.settle(finest, &mut state, true, None)?;
            averages = self.averages(&pass);
            if averages.is_none() {
                let full_iterations = state.iterations - before;
                return self.conclude(finest, &state, &pass, termination, full_iterations);
            }
        }
        let (pass, termination) = self.settle(finest, &mut state, true, averages.as_ref())?;
        let full_iterations = state.iterations - before;
        self.conclude(finest, &state, &pass, termination, full_iterations)
    }

    /// Averages over neighbours in the target, where they are worth it.
    fn averages(&self, pass: &Pass) -> Option<Averages> {
        let is_along_normals = self.options.objective != Objective::PointToPoint;
        let residual_mm2 = rms_mm(&pass.sums).powi(2);
        is_along_normals.then(|| self.target.averages(residual_mm2)).flatten()
    }

    /// Passes over one level until they move nothing any more.
    fn settle<'a>(
        &self,
        level: &mut Moving,
        state: &mut State,
        is_last: bool,
        averages: Option<&'a Averages>,
    ) -> Result<(Pass<'a>, Option<Termination>), RegisterError> {
        state.found_at = state.pose;
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
        pass::find(level, self.target, &state.found_at, &state.pose, &self.wanted);
        state.found_at = state.pose;
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

    fn conclude(
        &self,
        level: &Moving,
        state: &State,
        pass: &Pass,
        termination: Option<Termination>,
        full_iterations: usize,
    ) -> Result<Registration, RegisterError> {
        let (mut hessian, mut gradient) =
            chart::pulled_back(&state.xi, &pass.sums.hessian, &pass.sums.gradient);
        self.chart.add_priors(&state.xi, pass.sigma_mm, &mut hessian, &mut gradient);
        let information = Information::new(&hessian, &self.chart.free, self.arm_mm);
        let free = information.undetermined();
        if !free.is_empty() {
            let direction = |&k: &usize| self.direction(&information, k, state, pass);
            let directions = free.iter().map(direction).collect();
            return Err(RegisterError::Undetermined { directions });
        }
        let left = chart::jacobian(&state.xi);
        let covariance = left * information.covariance() * left.transpose();
        let registration = Registration {
            target_from_source: state.pose,
            covariance: covariance * pass.sigma_mm.powi(2) * self.shared_factor(level, state, pass),
            pivot_mm: self.chart.pivot,
            sigma_mm: pass.sigma_mm,
            rms_mm: rms_mm(&pass.sums),
            used: pass.sums.n_used,
            iterations: state.iterations,
            full_iterations,
            last_motion_mm: state.motion_mm,
            termination,
            observability: self.has_normals.then(|| self.observability(level, state, pass)),
        };
        if termination.is_none() {
            return Err(RegisterError::NotConverged { best: Box::new(registration) });
        }
        Ok(registration)
    }

    /// How much larger the variance is than that of independent rows, since rows share what an
    /// average over neighbours in the target is off by: 1 + (m − 1) ρ, with m rows to an average and
    /// their correlation ρ (Kish 1965).
    fn shared_factor(&self, level: &Moving, state: &State, pass: &Pass) -> f64 {
        let Some(averages) = pass.rules.averages else { return 1.0 };
        let slots = pass::slots_met(level, self.target, &state.found_at, &pass.rules);
        let correlation = averages.variance_mm2 / pass.sigma_mm.powi(2);
        1.0 + (averages.rows_to_one(&slots) - 1.0).max(0.0) * correlation.min(1.0)
    }

    /// From rows along the normals, without priors.
    fn observability(&self, level: &Moving, state: &State, pass: &Pass) -> Observability {
        let hessian = if self.options.objective == Objective::PointToPoint {
            let rules = Rules { objective: Objective::PointToPlane, ..pass.rules };
            pass::sum(level, self.target, &state.found_at, &rules).hessian
        } else {
            pass.sums.hessian
        };
        let (hessian, _) = chart::pulled_back(&state.xi, &hessian, &pass.sums.gradient);
        let information = Information::new(&hessian, &self.chart.free, self.arm_mm);
        let singular_values = information.singular_values.clone();
        let is_weak = |k: &usize| WeakDirection::is_weak(singular_values[*k] / singular_values[0]);
        let weak = (0..singular_values.len()).filter(is_weak);
        let weak = weak.map(|k| self.direction(&information, k, state, pass)).collect();
        Observability { singular_values, arm_mm: self.arm_mm, weak }
    }

    fn direction(
        &self,
        information: &Information,
        k: usize,
        state: &State,
        pass: &Pass,
    ) -> WeakDirection {
        let largest = information.singular_values[0];
        let singular_value = information.singular_values[k];
        let is_free = information.undetermined().contains(&k);
        WeakDirection {
            twist: chart::jacobian(&state.xi) * information.direction(k),
            pivot_mm: self.chart.pivot,
            arm_mm: self.arm_mm,
            relative_singular_value: if largest > 0.0 { singular_value / largest } else { 0.0 },
            sigma_mm: (!is_free).then(|| pass.sigma_mm / singular_value),
        }
    }
}

fn spread_mm(sums: &Sums, unknowns: usize) -> f64 {
    let freedom = sums.n_rows.saturating_sub(unknowns).max(1);
    (sums.squares_mm2 / as_f64(freedom)).sqrt()
}

fn rms_mm(sums: &Sums) -> f64 {
    (sums.squares_mm2 / as_f64(sums.n_used)).sqrt()
}

#[expect(clippy::cast_precision_loss, reason = "point counts are far below 2^53")]
fn as_f64(count: usize) -> f64 {
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
