//! The iteration: find what is nearest, solve for the motion, move.

use nalgebra::{Isometry3, Point3, Vector6};

use super::chart::{self, Chart};
use super::error::{RegisterError, Side};
use super::information::Information;
use super::moving::Moving;
use super::observability::{Observability, WeakDirection};
use super::options::{Objective, RegisterOptions};
use super::pass::{self, Rules};
use super::point_cloud::PointCloud;
use super::registration::{Registration, Termination};
use super::sums::Sums;
use super::target::{CloudTarget, Target};

/// Share of the target's spacing up to which leads are looked for: a pass near the end moves less.
const MARGIN_SPACINGS: f64 = 0.05;

/// A coarse level ends when a pass moves points by less than this share of its own uncertainty.
const COARSE_SHARE: f64 = 0.1;

/// Passes without a smaller motion after which points are taken to change their minds for ever.
const PATIENCE: usize = 5;

/// Share of the weakest direction's standard uncertainty that such a motion may have.
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
    let search = Search { target, has_normals, options, chart, arm_mm };
    search.run(Moving::levels(source))
}

struct Search<'a, T> {
    target: &'a T,
    has_normals: bool,
    options: &'a RegisterOptions,
    chart: Chart,
    arm_mm: f64,
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
    /// Standard uncertainty of the weakest direction.
    weakest_mm: f64,
}

/// What a pass found out.
struct Pass {
    sums: Sums,
    rules: Rules,
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
            weakest_mm: 0.0,
        };
        let (finest, coarse) = levels.split_last_mut().expect("the finest level is there");
        for level in coarse {
            self.settle(level, &mut state, false)?;
        }
        let before = state.iterations;
        let (pass, termination) = self.settle(finest, &mut state, true)?;
        let full_iterations = state.iterations - before;
        self.conclude(finest, &state, &pass, termination, full_iterations)
    }

    /// Passes over one level until they move nothing any more.
    fn settle(
        &self,
        level: &mut Moving,
        state: &mut State,
        is_last: bool,
    ) -> Result<(Pass, Option<Termination>), RegisterError> {
        state.found_at = state.pose;
        let (mut smallest_mm, mut waited) = (f64::INFINITY, 0);
        for n in 1.. {
            let pass = self.pass(level, state)?;
            self.step(level, state, &pass);
            let enough_mm = if is_last {
                self.options.tolerance_mm
            } else {
                self.options.tolerance_mm.max(COARSE_SHARE * pass.uncertainty_mm())
            };
            if is_last && state.motion_mm < pass.rules.sigma_mm {
                state.scale_mm = Some(pass.rules.sigma_mm);
            }
            waited = if state.motion_mm < smallest_mm { 0 } else { waited + 1 };
            smallest_mm = smallest_mm.min(state.motion_mm);
            if state.motion_mm <= enough_mm {
                return Ok((pass, Some(Termination::Motion)));
            }
            if waited >= PATIENCE && state.motion_mm <= SETTLED_SHARE * state.weakest_mm {
                return Ok((pass, Some(Termination::Settled)));
            }
            if n >= self.options.max_iterations {
                return Ok((pass, None));
            }
        }
        unreachable!("the loop ends by returning")
    }

    fn pass(&self, level: &mut Moving, state: &mut State) -> Result<Pass, RegisterError> {
        let limit_mm = self.options.max_distance_mm.unwrap_or(f64::INFINITY);
        let margin_mm = MARGIN_SPACINGS * self.target.spacing_mm();
        pass::find(level, self.target, &state.found_at, &state.pose, limit_mm, margin_mm);
        state.found_at = state.pose;
        let rules = self.rules(level, state, limit_mm);
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

    fn rules(&self, level: &Moving, state: &State, limit_mm: f64) -> Rules {
        let options = self.options;
        let mut rules = Rules {
            objective: options.objective,
            pivot: self.chart.pivot,
            skip_beside: options.skip_beyond_border && self.has_normals,
            limit_mm,
            keep_below_mm2: f64::INFINITY,
            loss: options.loss,
            sigma_mm: state.scale_mm.unwrap_or(1.0),
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

    fn step(&self, level: &Moving, state: &mut State, pass: &Pass) {
        let (mut hessian, mut gradient) =
            chart::pulled_back(&state.xi, &pass.sums.hessian, &pass.sums.gradient);
        self.chart.add_priors(&state.xi, pass.sigma_mm, &mut hessian, &mut gradient);
        let information = Information::new(&hessian, &self.chart.free, self.arm_mm);
        state.weakest_mm = pass.sigma_mm / information.weakest();
        let mut step = information.step(&gradient);
        let turn_rad = step.fixed_rows::<3>(3).norm();
        if turn_rad > MAX_STEP_RAD {
            step *= MAX_STEP_RAD / turn_rad;
        }
        let before = state.pose;
        state.xi += step;
        state.pose = self.chart.pose(&state.xi);
        state.motion_mm = level.motion_mm(&before, &state.pose);
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
            covariance: covariance * pass.sigma_mm.powi(2),
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

impl Pass {
    /// Roughly how far the pose that this pass leads to is off by chance.
    fn uncertainty_mm(&self) -> f64 {
        self.sigma_mm / as_f64(self.sums.n_used).sqrt()
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
