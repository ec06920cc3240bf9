//! What the covariance says: intervals, other pivots, transformed points.

use nalgebra::{DMatrix, DVector, Point, SMatrix, SVector};

use crate::statistics::{normal_quantile, ratio, student_quantile};
use crate::{FrameFit, Noise, PointPair, motion};

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
        let motions = motion::motions(self.transform, D);
        motions.iter().map(|m| FrameParameter { name: m.name(), unit: m.unit() }).collect()
    }

    /// Standard uncertainty of each parameter; a posteriori where the noise is estimated.
    ///
    /// `None` where the noise is to be estimated and there is no redundancy to do it with.
    #[must_use]
    pub fn standard_uncertainties(&self) -> Option<DVector<f64>> {
        let factor = self.noise_factor()?;
        Some(self.covariance.diagonal().map(|variance| (variance * factor).sqrt()))
    }

    /// Half width of the interval of each parameter at the two-sided `confidence` (0 to 1).
    ///
    /// Normal where the noise is declared, Student's t where it is estimated. `None` where there
    /// is no redundancy to estimate the noise with, or `confidence` is not between 0 and 1.
    #[must_use]
    pub fn half_widths(&self, confidence: f64) -> Option<DVector<f64>> {
        if !(0.0..1.0).contains(&confidence) {
            return None;
        }
        let probability = f64::midpoint(1.0, confidence);
        let coverage_factor = match self.noise {
            Noise::Declared => normal_quantile(probability),
            Noise::Estimated => student_quantile(probability, self.degrees_of_freedom),
        };
        Some(self.standard_uncertainties()? * coverage_factor)
    }

    /// A-priori covariance of the parameters about another pivot of the target frame.
    ///
    /// With the frame's origin the perturbation is `T = exp(ξ) T̂`.
    #[must_use]
    pub fn covariance_about(&self, pivot_mm: &Point<f64, D>) -> DMatrix<f64> {
        let motions = motion::motions(self.transform, D);
        // The same motion: what it does at the new pivot is the new translation.
        let mut moved = DMatrix::identity(motions.len(), motions.len());
        if self.transform.has_translation() {
            let jacobian = motion::jacobian(&motions, &(pivot_mm - self.pivot_mm));
            moved.rows_mut(0, D).copy_from(&jacobian);
        }
        &moved * &self.covariance * moved.transpose()
    }

    /// Covariance of the image of a point of the source frame, from that of the transform alone;
    /// a posteriori where the noise is estimated. `None` as for
    /// [`FrameFit::standard_uncertainties`].
    #[must_use]
    pub fn point_covariance_mm2(&self, source_mm: &Point<f64, D>) -> Option<SMatrix<f64, D, D>> {
        let image_mm = self.target_from_source.apply(source_mm);
        let motions = motion::motions(self.transform, D);
        let jacobian = motion::jacobian(&motions, &(image_mm - self.pivot_mm));
        let covariance = &jacobian * &self.covariance * jacobian.transpose();
        Some(SMatrix::from_column_slice(covariance.as_slice()) * self.noise_factor()?)
    }

    /// `target − T·source` of a pair that need not have been fitted.
    #[must_use]
    pub fn residual_mm(&self, pair: &PointPair<D>) -> SVector<f64, D> {
        pair.target_mm - self.target_from_source.apply(&pair.source_mm)
    }

    /// Root-mean-square distance of the points from their partners.
    #[must_use]
    pub fn rms_mm(&self) -> f64 {
        let squares: f64 = self.residuals_mm.iter().map(SVector::norm_squared).sum();
        (squares / ratio(self.residuals_mm.len())).sqrt()
    }

    /// What the a-priori covariance has to be multiplied by.
    fn noise_factor(&self) -> Option<f64> {
        match self.noise {
            Noise::Declared => Some(1.0),
            Noise::Estimated => self.variance_factor,
        }
    }
}
