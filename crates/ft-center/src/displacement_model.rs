//! Tables of commanded and solved displacements as a model for the loop.

use model_discrepancy::{Covariate, Effect, Layout, Model, Parameter, State};
use nalgebra::{DMatrix, DVector};

use crate::FtCenterError;

/// One row of a table of displacements.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Displacement {
    /// Name of the row.
    pub point: String,
    /// How far the machine moved.
    pub commanded_mm: f64,
    /// How far the sensor found it to have moved.
    pub solved_mm: f64,
}

/// Solved against commanded displacements; the declared model claims that they are equal.
#[derive(Debug)]
pub struct DisplacementModel {
    layout: Layout,
}

impl DisplacementModel {
    /// Builds the model of a table; `sigma_mm` is the declared standard uncertainty of a solved
    /// displacement, `None` lets the residual tell.
    ///
    /// # Errors
    ///
    /// [`FtCenterError::Empty`], [`FtCenterError::NotFinite`], [`FtCenterError::NotPositive`].
    pub fn new(rows: &[Displacement], sigma_mm: Option<f64>) -> Result<Self, FtCenterError> {
        let _ = (rows, sigma_mm);
        unimplemented!("lands with the next commit")
    }

    /// The commanded displacement as a covariate for the loop.
    #[must_use]
    pub fn covariates(&self) -> Vec<Covariate> {
        unimplemented!("lands with the next commit")
    }
}

impl Model for DisplacementModel {
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
