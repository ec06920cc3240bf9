//! The search over all levels of detail, and what is known of the pose in the end.

use super::averages::Averages;
use super::chart;
use super::error::{RegisterError, Side};
use super::information::Information;
use super::moving::Moving;
use super::observability::{Observability, WeakDirection};
use super::options::{Objective, RegisterOptions};
use super::pass::{self, Rules};
use super::point_cloud::PointCloud;
use super::registration::{Registration, Termination};
use super::search::{Pass, Search, State, rms_mm};
use super::start;
use super::target::{CloudTarget, Target};

/// Moves a cloud onto another.
///
/// Repeats: take the nearest target point of each source point, solve the linearised problem, move
/// (Chen and Medioni 1991), first with few source points, then with ever more
/// of them. A point keeps its nearest unasked while it provably stays nearest. Where noise of the
/// target's points shows in the residuals, the tangent plane goes through the average of the few
/// points about the nearest one. Where the source comes to lie elsewhere than on the target, other
/// starts about the one given are tried, unless a distance limit is set. Runs on the threads
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
    let search = Search::new(source, target, has_normals, options)?;
    search.run(Moving::levels(source))
}

impl<T: Target> Search<'_, T> {
    fn run(&self, mut levels: Vec<Moving>) -> Result<Registration, RegisterError> {
        let mut state = self.at_start();
        let mut averages = None;
        let n_levels = levels.len();
        for (l, level) in levels.iter_mut().enumerate() {
            let is_last = l + 1 == n_levels;
            let mut before = state.iterations;
            let mut settled = self.settle(level, &mut state, is_last, averages.as_ref());
            if l == 0
                && let Some(better) = start::other_start(self, level, &settled, &state)
            {
                state = better;
                before = state.iterations;
                settled = self.settle(level, &mut state, is_last, None);
            }
            let (mut pass, mut termination) = settled?;
            let found = self.averages(&pass);
            if !is_last {
                averages = found;
                continue;
            }
            if l == 0 && found.is_some() {
                (pass, termination) = self.settle(level, &mut state, is_last, found.as_ref())?;
            }
            let full_iterations = state.iterations - before;
            return self.conclude(level, &state, &pass, termination, full_iterations);
        }
        unreachable!("there is a last level")
    }

    /// Averages over neighbours in the target, where they are worth it.
    fn averages(&self, pass: &Pass) -> Option<Averages> {
        let is_along_normals = self.options.objective != Objective::PointToPoint;
        let residual_mm2 = rms_mm(&pass.sums).powi(2);
        is_along_normals.then(|| self.target.averages(residual_mm2)).flatten()
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
        let slots =
            pass::slots_met(level, self.target, &level.found_at.unwrap_or(state.pose), &pass.rules);
        let correlation = averages.variance_mm2 / pass.sigma_mm.powi(2);
        1.0 + (averages.rows_to_one(&slots) - 1.0).max(0.0) * correlation.min(1.0)
    }

    /// From rows along the normals, without priors.
    fn observability(&self, level: &Moving, state: &State, pass: &Pass) -> Observability {
        let hessian = if self.options.objective == Objective::PointToPoint {
            let rules = Rules { objective: Objective::PointToPlane, ..pass.rules };
            pass::sum(level, self.target, &level.found_at.unwrap_or(state.pose), &rules).hessian
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
