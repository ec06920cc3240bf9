//! The presses as a model for the loop.

use model_discrepancy::{Covariate, Effect, Layout, Model, Parameter, Proposal, State};
use nalgebra::{DMatrix, DVector};

use crate::{Contact, FtCenterError, LocateOptions, Located, SolvedPress};

/// Presses, their planar frame, and what the frame leaves out.
#[derive(Debug)]
pub struct PressModel {
    layout: Layout,
}

impl PressModel {
    /// Builds the model of a case of presses.
    ///
    /// `covariates` have one value per *observation*: per press of role `Frame` or `Check`, in
    /// input order; see [`PressModel::observed`]. A column whose name ends in `_c` becomes a
    /// `temperature` effect.
    ///
    /// # Errors
    ///
    /// As [`locate`](crate::locate), and [`FtCenterError::CovariateLength`].
    pub fn new(
        presses: &[SolvedPress],
        contact: &Contact,
        options: &LocateOptions,
        covariates: &[Covariate],
    ) -> Result<Self, FtCenterError> {
        let _ = (presses, contact, options, covariates);
        unimplemented!("lands with the next commit")
    }

    /// Index into the presses given of each observation of the layout.
    #[must_use]
    pub fn observed(&self) -> &[usize] {
        unimplemented!("lands with the next commit")
    }

    /// Position in the machine and mean load of each observation, as covariates for the loop.
    #[must_use]
    pub fn covariates(&self) -> Vec<Covariate> {
        unimplemented!("lands with the next commit")
    }

    /// Frame and centres of all presses, those to be located too, with the effects in `at`.
    ///
    /// `covariance` is that of `[base, active amplitudes in catalogue order]`, as
    /// [`Closure::covariance`](model_discrepancy::Closure::covariance).
    #[must_use]
    pub fn located(&self, at: &State, covariance: &DMatrix<f64>) -> Located {
        let _ = (at, covariance);
        unimplemented!("lands with the next commit")
    }
}

impl Model for PressModel {
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

    fn proposals(&self) -> Vec<Proposal> {
        unimplemented!("lands with the next commit")
    }
}
