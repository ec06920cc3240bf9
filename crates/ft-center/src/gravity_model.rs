//! Static poses as a model for the loop.

use model_discrepancy::{Covariate, Effect, Layout, Model, Parameter, State};
use nalgebra::{DMatrix, DVector};

use crate::{FtCenterError, GravityCalibration, GravityOptions, StaticPose};

/// Static poses, their calibration, and what it leaves out.
///
/// Reported rows are forces in N; moment rows take part in the fit and are not reported.
#[derive(Debug)]
pub struct GravityModel {
    layout: Layout,
}

impl GravityModel {
    /// Builds the model of a case of static poses, in the order measured.
    ///
    /// # Errors
    ///
    /// As [`calibrate_gravity`](crate::calibrate_gravity), and
    /// [`FtCenterError::CovariateLength`].
    pub fn new(
        poses: &[StaticPose],
        options: &GravityOptions,
        covariates: &[Covariate],
    ) -> Result<Self, FtCenterError> {
        let _ = (poses, options, covariates);
        unimplemented!("lands with the next commit")
    }

    /// Direction of gravity in sensor axes, as covariates for the loop.
    #[must_use]
    pub fn covariates(&self) -> Vec<Covariate> {
        unimplemented!("lands with the next commit")
    }

    /// Calibration with the effects in `at`; covariance as [`PressModel::located`].
    ///
    /// [`PressModel::located`]: crate::PressModel::located
    #[must_use]
    pub fn calibration(&self, at: &State, covariance: &DMatrix<f64>) -> GravityCalibration {
        let _ = (at, covariance);
        unimplemented!("lands with the next commit")
    }
}

impl Model for GravityModel {
    fn layout(&self) -> &Layout {
        &self.layout
    }

    fn base(&self) -> &[Parameter] {
        unimplemented!("lands with the next commit")
    }

    fn effects(&self) -> &[Effect] {
        unimplemented!("lands with the next commit")
    }

    fn start(&self) -> DVector<f64> {
        unimplemented!("lands with the next commit")
    }

    fn residuals(&self, _at: &State) -> DVector<f64> {
        unimplemented!("lands with the next commit")
    }

    fn base_jacobian(&self, _at: &State) -> DMatrix<f64> {
        unimplemented!("lands with the next commit")
    }

    fn tangent(&self, _at: &State, _effect: usize) -> DMatrix<f64> {
        unimplemented!("lands with the next commit")
    }
}
