//! What the covariance says: intervals, other pivots, transformed points.

use nalgebra::{DMatrix, DVector, Point, SMatrix, SVector};

use crate::{FrameFit, PointPair};

/// Name and unit of one parameter of a transform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FrameParameter {
    /// `tx`, `ty`, `tz`, `rx`, `ry`, `rz`, `scale`, `scale_x` …, `shear_xy` ….
    pub name: &'static str,
    /// `mm`, `rad`, or `1` for a ratio.
    pub unit: &'static str,
}

impl<const D: usize> FrameFit<D> {
    /// Parameters of the rows and columns of `covariance`.
    #[must_use]
    pub fn parameters(&self) -> Vec<FrameParameter> {
        todo!()
    }

    /// Standard uncertainty of each parameter; a posteriori where the noise is estimated.
    ///
    /// `None` where the noise is to be estimated and there is no redundancy to do it with.
    #[must_use]
    pub fn standard_uncertainties(&self) -> Option<DVector<f64>> {
        todo!()
    }

    /// Half width of the interval of each parameter at the two-sided `confidence` (0 to 1).
    ///
    /// Normal where the noise is declared, Student's t where it is estimated. `None` where there
    /// is no redundancy to estimate the noise with, or `confidence` is not between 0 and 1.
    #[must_use]
    pub fn half_widths(&self, confidence: f64) -> Option<DVector<f64>> {
        todo!()
    }

    /// A-priori covariance of the parameters about another pivot of the target frame.
    ///
    /// With the frame's origin the perturbation is `T = exp(ξ) T̂`.
    #[must_use]
    pub fn covariance_about(&self, pivot_mm: &Point<f64, D>) -> DMatrix<f64> {
        todo!()
    }

    /// Covariance of the image of a point of the source frame, from that of the transform alone;
    /// a posteriori where the noise is estimated. `None` as for
    /// [`FrameFit::standard_uncertainties`].
    #[must_use]
    pub fn point_covariance_mm2(&self, source_mm: &Point<f64, D>) -> Option<SMatrix<f64, D, D>> {
        todo!()
    }

    /// `target − T·source` of a pair that need not have been fitted.
    #[must_use]
    pub fn residual_mm(&self, pair: &PointPair<D>) -> SVector<f64, D> {
        pair.target_mm - self.target_from_source.apply(&pair.source_mm)
    }

    /// Root-mean-square distance of the points from their partners.
    #[must_use]
    pub fn rms_mm(&self) -> f64 {
        todo!()
    }
}
