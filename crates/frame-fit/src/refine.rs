//! The estimate by Levenberg-Marquardt from the closed form, for any uncertainty and loss.

use least_squares::{Loss, Problem, RobustRows, Solution, SolveError};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use crate::motion::{self, Motion};
use crate::{FrameFitError, FrameMap, Noise, Options, PointPair, Transform};

/// Whitened residuals `W (target − T·source)` of every pair.
pub(crate) struct FitProblem<'a, const D: usize> {
    pairs: &'a [PointPair<D>],
    whitening_per_mm: Vec<SMatrix<f64, D, D>>,
    transform: Transform,
    pub(crate) motions: Vec<Motion>,
    pub(crate) pivot_mm: SVector<f64, D>,
}

impl<'a, const D: usize> FitProblem<'a, D> {
    /// The pivot is the weighted centroid of the points as `near` maps them.
    pub(crate) fn new(pairs: &'a [PointPair<D>], transform: Transform, near: &FrameMap<D>) -> Self {
        let mut pivot_mm = SVector::zeros();
        let mut total = 0.0;
        for pair in pairs {
            let weight = pair.uncertainty.mean_weight_per_mm2();
            total += weight;
            pivot_mm += (near.apply(&pair.source_mm).coords - pivot_mm) * (weight / total);
        }
        let whitening = |p: &PointPair<D>| p.uncertainty.whitening_per_mm().expect("checked");
        Self {
            pairs,
            whitening_per_mm: pairs.iter().map(whitening).collect(),
            transform,
            motions: motion::motions(transform, D),
            pivot_mm,
        }
    }

    /// Weighted sum of squares that rounding of the coordinates leaves of an exact fit.
    pub(crate) fn round_off_chi2(&self, at: &FrameMap<D>) -> f64 {
        let of_pair = |pair: &PointPair<D>, whitening: &SMatrix<f64, D, D>| {
            let largest_mm =
                [pair.target_mm.coords.amax(), at.apply(&pair.source_mm).coords.amax()]
                    .into_iter()
                    .fold(at.translation_mm.amax(), f64::max);
            (whitening.norm() * ROUND_OFF_ULPS * f64::EPSILON * largest_mm).powi(2)
        };
        let pairs = self.pairs.iter().zip(&self.whitening_per_mm);
        pairs.map(|(pair, whitening)| of_pair(pair, whitening)).sum()
    }
}

/// Units in the last place of a coordinate that a transform of a point may lose.
const ROUND_OFF_ULPS: f64 = 8.0;

impl<const D: usize> Problem for FitProblem<'_, D> {
    type Point = FrameMap<D>;

    fn residual_count(&self) -> usize {
        D * self.pairs.len()
    }

    fn tangent_dim(&self) -> usize {
        self.motions.len()
    }

    fn residuals(&self, at: &FrameMap<D>, out: &mut DVector<f64>) {
        for (i, (pair, whitening)) in self.pairs.iter().zip(&self.whitening_per_mm).enumerate() {
            let residual = whitening * (pair.target_mm - at.apply(&pair.source_mm));
            out.fixed_rows_mut::<D>(D * i).copy_from(&residual);
        }
    }

    fn jacobian(&self, at: &FrameMap<D>, out: &mut DMatrix<f64>) {
        for (i, (pair, whitening)) in self.pairs.iter().zip(&self.whitening_per_mm).enumerate() {
            let arm_mm = at.apply(&pair.source_mm).coords - self.pivot_mm;
            for (column, motion) in self.motions.iter().enumerate() {
                let moved = whitening * motion.displacement(&arm_mm);
                out.fixed_view_mut::<D, 1>(D * i, column).copy_from(&-moved);
            }
        }
    }

    fn retract(&self, at: &FrameMap<D>, step: &DVector<f64>) -> FrameMap<D> {
        motion::finite(self.transform, &self.motions, &self.pivot_mm, step).after(at)
    }

    fn parameter_name(&self, index: usize) -> String {
        self.motions[index].name().to_owned()
    }
}

/// Refines `start` until it minimises the weighted squares, or the loss that `options` names.
pub(crate) fn refine<const D: usize>(
    problem: &FitProblem<'_, D>,
    start: FrameMap<D>,
    options: &Options,
) -> Result<Solution<FrameMap<D>>, FrameFitError> {
    let plain = solve(problem, start, None)?;
    let Some(loss) = options.loss else { return Ok(plain) };
    // Huber's loss is convex for all but the rotation, so that a start spoilt by outliers is
    // mended before a loss that ignores them could lock on to it.
    let mut huber = plain;
    for _ in 0..SCALE_PASSES {
        let sigma = robust_sigma(&huber, D, options.noise);
        let convex = Loss::Huber { scale: sigma * scale_of(loss) };
        huber = solve(problem, huber.point, Some(convex))?;
    }
    let sigma = robust_sigma(&huber, D, options.noise);
    solve(problem, huber.point, Some(with_scale(loss, sigma * scale_of(loss))))
}

/// Passes over estimated noise and robust fit; the scale settles to a percent in three.
const SCALE_PASSES: usize = 3;

/// Standard deviation of a whitened coordinate: 1 when declared, else from the median distance,
/// which half of the points being bad does not move far.
fn robust_sigma<const D: usize>(
    solution: &Solution<FrameMap<D>>,
    dimension: usize,
    noise: Noise,
) -> f64 {
    if noise == Noise::Declared {
        return 1.0;
    }
    let mut distances: Vec<f64> = solution
        .residuals
        .as_slice()
        .chunks(dimension)
        .map(|r| r.iter().map(|v| v * v).sum())
        .map(f64::sqrt)
        .collect();
    distances.sort_by(f64::total_cmp);
    let median = distances[distances.len() / 2];
    // Median of the chi distribution with 2 and 3 degrees of freedom.
    let median_of_unit_noise = if dimension == 2 { 1.177_410 } else { 1.538_172 };
    // A fit without redundancy leaves nothing to judge; any positive scale then keeps all points.
    (median / median_of_unit_noise).max(f64::MIN_POSITIVE.sqrt())
}

fn scale_of(loss: Loss) -> f64 {
    match loss {
        Loss::Huber { scale }
        | Loss::Cauchy { scale }
        | Loss::Tukey { scale }
        | Loss::GemanMcClure { scale } => scale,
    }
}

fn with_scale(loss: Loss, scale: f64) -> Loss {
    match loss {
        Loss::Huber { .. } => Loss::Huber { scale },
        Loss::Cauchy { .. } => Loss::Cauchy { scale },
        Loss::Tukey { .. } => Loss::Tukey { scale },
        Loss::GemanMcClure { .. } => Loss::GemanMcClure { scale },
    }
}

fn solve<const D: usize>(
    problem: &FitProblem<'_, D>,
    start: FrameMap<D>,
    loss: Option<Loss>,
) -> Result<Solution<FrameMap<D>>, FrameFitError> {
    let robust = loss.map(|loss| RobustRows::all(D, loss)).into_iter().collect();
    let options = least_squares::Options { robust, ..least_squares::Options::default() };
    least_squares::solve(problem, start, &options).map_err(|error| match error {
        SolveError::Unobservable { directions, .. } => FrameFitError::Unobservable { directions },
        SolveError::InvalidLoss { scale, .. } => FrameFitError::InvalidLoss { scale },
        SolveError::NotConverged { report, .. } => {
            FrameFitError::NotConverged { iterations: report.iterations, cost: report.final_cost }
        }
        // Finite input within bounds gives finite residuals and derivatives.
        _ => FrameFitError::NotConverged { iterations: 0, cost: f64::NAN },
    })
}
