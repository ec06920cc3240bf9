//! A pose that was fitted.

use geometry::Foot;
use nalgebra::{Isometry3, Matrix6, Vector6};

use crate::{Noise, PoseStart, WeakMotion};

/// Pose of a workpiece with its uncertainty and what it leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseFit {
    /// Maps workpiece to machine coordinates.
    pub machine_from_workpiece: Isometry3<f64>,
    /// The same as position of the workpiece's origin and Euler angles.
    pub pose: PoseStart,
    /// A-priori covariance of `[x y z α β γ]`; mm², mm·rad, rad²; zero rows for held parameters.
    pub covariance: Matrix6<f64>,
    /// Distance of each ball's centre from the surface less the ball's radius, on its own side
    /// positive away from the surface along the surface's normal; in input order.
    pub residuals_mm: Vec<f64>,
    /// Where the balls touch, in the workpiece frame, in input order.
    pub contacts: Vec<Foot>,
    /// Equations minus free parameters.
    pub degrees_of_freedom: usize,
    /// Weighted sum of squares over `degrees_of_freedom`; `None` without redundancy.
    pub variance_factor: Option<f64>,
    /// What the uncertainties of the touches were taken to mean.
    pub noise: Noise,
    /// Of the whitened Jacobian by `[x y z α β γ]` without the held ones, the largest first, with
    /// angles measured by the travel they cause at the touches.
    pub singular_values: Vec<f64>,
    /// Motions that the touches hardly show, the weakest last.
    pub weak_directions: Vec<WeakMotion>,
    /// Steps accepted.
    pub iterations: usize,
    /// Poses at which the equations were evaluated.
    pub evaluations: usize,
}

impl PoseFit {
    /// Standard uncertainties of `[x y z α β γ]`, mm and rad; 0 where held.
    ///
    /// A posteriori where the noise was estimated, and then `None` without redundancy.
    #[must_use]
    pub fn standard_uncertainties(&self) -> Option<Vector6<f64>> {
        let scale = self.covariance_scale()?.sqrt();
        Some(self.covariance.diagonal().map(|v| v.max(0.0).sqrt()) * scale)
    }

    /// Factor from `covariance` to the covariance to be reported.
    pub(crate) fn covariance_scale(&self) -> Option<f64> {
        match self.noise {
            Noise::Declared => Some(1.0),
            Noise::Estimated => self.variance_factor,
        }
    }
}
