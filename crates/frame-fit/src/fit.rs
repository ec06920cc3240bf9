//! The estimate, and the function that makes it.

use least_squares::Report;
use nalgebra::{DMatrix, Point, SVector};

use crate::motion::Motion;
use crate::problem::FitProblem;
use crate::refine::refine;
use crate::spread::{Spread, check_spread};
use crate::{
    FrameFitError, FrameMap, Handedness, Noise, Options, PointPair, Reflection, Transform,
    closed_form, input, reflection,
};

/// Estimated transform with its uncertainty and the residuals it leaves.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FrameFit<const D: usize> {
    /// Family of the transform.
    pub transform: Transform,
    /// Whether the estimate mirrors.
    pub handedness: Handedness,
    /// Maps source coordinates to target coordinates.
    pub target_from_source: FrameMap<D>,
    /// Weighted centroid of the transformed points, in the target frame: the point about which
    /// the parameters of `covariance` rotate and stretch.
    pub pivot_mm: Point<f64, D>,
    /// A-priori covariance of the parameters named by [`FrameFit::parameters`], for a
    /// perturbation on the left about `pivot_mm`; mm², mm·rad, rad².
    ///
    /// [`FrameFit::covariance_about`] moves it to another pivot, such as the frame's origin.
    pub covariance: DMatrix<f64>,
    /// `target − T·source`, in input order.
    pub residuals_mm: Vec<SVector<f64, D>>,
    /// Robust weight of each point, in input order; all 1 without a loss.
    pub weights: Vec<f64>,
    /// Coordinates used minus parameters.
    pub degrees_of_freedom: usize,
    /// Weighted sum of squares over `degrees_of_freedom`; near 1 when the uncertainties are
    /// honest. `None` when there is no redundancy.
    pub variance_factor: Option<f64>,
    /// What the uncertainties of the pairs were taken to mean.
    pub noise: Noise,
    /// Root-mean-square spread of the source points along their principal directions, the
    /// largest first.
    pub spreads_mm: SVector<f64, D>,
    /// Whether the data speak for a mirrored frame; `None` where the points do not span enough
    /// to judge.
    pub reflection: Option<Reflection>,
    /// How the search went from the closed form, and the condition of the problem.
    pub report: Report,
}

/// Standard uncertainty of a rotation (rad) or a ratio beyond which the linearised covariance,
/// and with it the estimate, means nothing: one sigma of 14°.
const LARGEST_SIGMA: f64 = 0.25;
/// Gap between two rotations that rounding alone may leave, see [`FrameFitError::Ambiguous`].
const SMALLEST_GAP: f64 = 1e-9;

/// Fits the transform from source to target.
///
/// # Errors
///
/// See [`FrameFitError`]; every variant means that no transform is available.
pub fn fit_frame<const D: usize>(
    pairs: &[PointPair<D>],
    options: &Options,
) -> Result<FrameFit<D>, FrameFitError> {
    const { assert!(D == 2 || D == 3, "a frame is planar or spatial") };
    input::check_pairs(pairs)?;
    input::check_count(options.transform, D, pairs.len())?;
    let spread = check_spread(pairs, options.transform)?;
    let reflection = reflection::judge(pairs, options);
    fit_checked(pairs, options, &spread, reflection).map_err(|error| match error {
        // Symmetric bodies and shrunken scales: the mirror is the cause.
        FrameFitError::Ambiguous { .. }
        | FrameFitError::TooNoisy { .. }
        | FrameFitError::NotConverged { .. }
        | FrameFitError::Unobservable { .. } => mirrored(reflection, options).unwrap_or(error),
        _ => error,
    })
}

fn fit_checked<const D: usize>(
    pairs: &[PointPair<D>],
    options: &Options,
    spread: &Spread<D>,
    reflection: Option<Reflection>,
) -> Result<FrameFit<D>, FrameFitError> {
    let start = closed_form::estimate(pairs, options.transform, options.handedness);
    if start.relative_gap.is_nan() || start.relative_gap <= SMALLEST_GAP {
        return Err(FrameFitError::Ambiguous { relative_gap: start.relative_gap });
    }
    let problem = FitProblem::new(pairs, options.transform, &start.map);
    let solution = refine(&problem, options)?;
    let map = problem.map(&solution.point);
    let fit = FrameFit {
        transform: options.transform,
        handedness: map.handedness(),
        target_from_source: map,
        pivot_mm: Point::from(problem.pivot_mm),
        covariance: solution.covariance,
        residuals_mm: pairs.iter().map(|p| p.target_mm - map.apply(&p.source_mm)).collect(),
        weights: solution.weights.iter().copied().step_by(D).collect(),
        degrees_of_freedom: solution.degrees_of_freedom,
        variance_factor: solution.variance_factor,
        noise: options.noise,
        spreads_mm: spread.rms_mm,
        reflection,
        report: solution.report,
    };
    check_noise(&fit, &problem.motions)?;
    Ok(fit)
}

/// The error to give where the data speak decisively for the other handedness.
fn mirrored(reflection: Option<Reflection>, options: &Options) -> Option<FrameFitError> {
    let reflection = reflection?;
    let handedness = options.handedness;
    let asked = matches!(options.transform, Transform::Rigid | Transform::Similarity);
    (asked && reflection.speaks_against(handedness)).then(|| FrameFitError::Mirrored {
        handedness,
        rms_mm: reflection.rms_mm(handedness),
        other_rms_mm: reflection.rms_mm(handedness.opposite()),
    })
}

fn check_noise<const D: usize>(fit: &FrameFit<D>, motions: &[Motion]) -> Result<(), FrameFitError> {
    let Some(sigmas) = fit.standard_uncertainties() else { return Ok(()) };
    let worst = (0..motions.len())
        .filter(|&k| !motions[k].is_translation() && sigmas[k] > LARGEST_SIGMA)
        .max_by(|&a, &b| sigmas[a].total_cmp(&sigmas[b]));
    worst.map_or(Ok(()), |k| {
        Err(FrameFitError::TooNoisy {
            parameter: motions[k].name(),
            sigma: sigmas[k],
            spreads_mm: fit.spreads_mm.iter().copied().collect(),
        })
    })
}
