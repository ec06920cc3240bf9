//! New starts along a direction that the Jacobian does not see where a search ended.
//!
//! Such an end is either a true freedom, along which nothing ever changes, or the floor of a
//! curved valley (or a parameter lost at infinity) that only looks flat from where it is.

use nalgebra::DVector;

use crate::covariance::Factored;
use crate::linearised::Evaluated;
use crate::search::{Counts, Found};
use crate::{Options, Problem};

/// Directions to try, the weakest first.
const DIRECTIONS: usize = 2;
/// Where to start, in units of the distance at which the residuals have changed by their norm.
const MULTIPLES: [f64; 3] = [1.0, 2.0, 4.0];
/// Shortest and longest step, in units of the way already come along the direction.
const SHORTEST: f64 = 1e-6;
const LONGEST: f64 = 1e6;
/// Factor between trial lengths, and halvings of the last interval.
const STRIDE: f64 = 4.0;
const HALVINGS: usize = 5;
/// Share in a direction from which a parameter counts for its length.
const MAIN_SHARE: f64 = 0.1;

pub(crate) fn starts<P: Problem>(
    problem: &P,
    options: &Options,
    found: &Found<P::Point>,
    factored: &Factored,
    counts: &mut Counts,
) -> Vec<P::Point> {
    let mut walk = Walk {
        problem,
        options,
        found,
        counts,
        tangent: DVector::zeros(problem.tangent_dim()),
        trial: Evaluated::new(problem.residual_count()),
    };
    let mut starts = Vec::new();
    for (share, step) in factored.weakest_directions().take(DIRECTIONS) {
        let unit = characteristic_length(&share, &step, &found.path);
        for direction in [&step * unit, &step * -unit] {
            if let Some(reach) = walk.reach(&direction) {
                starts.extend(MULTIPLES.map(|m| walk.point(&direction, m * reach)));
            }
        }
    }
    starts
}

/// Length of `step` that equals the way already come in its main parameters.
fn characteristic_length(share: &DVector<f64>, step: &DVector<f64>, path: &DVector<f64>) -> f64 {
    let main = (0..step.len()).filter(|&k| share[k].abs() >= MAIN_SHARE * share.amax());
    let come = main.map(|k| (path[k] / step[k]).abs()).fold(0.0, f64::max);
    if come > 0.0 { come } else { 1.0 / step.amax() }
}

struct Walk<'a, P: Problem> {
    problem: &'a P,
    options: &'a Options,
    found: &'a Found<P::Point>,
    counts: &'a mut Counts,
    tangent: DVector<f64>,
    trial: Evaluated,
}

impl<P: Problem> Walk<'_, P> {
    fn point(&mut self, direction: &DVector<f64>, length: f64) -> P::Point {
        self.found.at.spread(&(direction * length), &mut self.tangent);
        self.problem.retract(&self.found.point, &self.tangent)
    }

    /// Whether the residuals at that length differ from those here by as much as their norm.
    fn changed(&mut self, direction: &DVector<f64>, length: f64) -> bool {
        let point = self.point(direction, length);
        self.counts.residuals += 1;
        self.trial.fill(self.problem, &point, self.options);
        let here = &self.found.at.evaluated.residuals;
        let change = (&self.trial.residuals - here).norm();
        !change.is_finite() || change >= here.norm()
    }

    /// The shortest length at which the residuals have changed; `None` if they never do.
    fn reach(&mut self, direction: &DVector<f64>) -> Option<f64> {
        let mut far = SHORTEST;
        while !self.changed(direction, far) {
            far *= STRIDE;
            if far > LONGEST {
                return None;
            }
        }
        let mut near = far / STRIDE;
        for _ in 0..HALVINGS {
            let middle = (near * far).sqrt();
            if self.changed(direction, middle) { far = middle } else { near = middle }
        }
        Some(far)
    }
}
