//! The estimate, and the function that makes it.

use least_squares::Report;
use nalgebra::{DMatrix, Point, SVector};

use crate::{FrameFitError, FrameMap, Handedness, Noise, Options, PointPair, Reflection, Transform};

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
    /// Condition number of the whitened, column-scaled Jacobian; 1 where nothing is estimated.
    pub condition: f64,
    /// Root-mean-square spread of the source points along their principal directions, the
    /// largest first.
    pub spreads_mm: SVector<f64, D>,
    /// Whether the data speak for a mirrored frame.
    pub reflection: Reflection,
    /// How the search went; `None` where nothing is estimated.
    pub report: Option<Report>,
}

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
    todo!()
}
