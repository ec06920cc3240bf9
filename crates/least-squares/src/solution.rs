use nalgebra::{DMatrix, DVector};

use crate::Report;

/// A converged estimate of full rank, with its uncertainty.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Solution<Point> {
    /// The estimate.
    pub point: Point,
    /// A-priori covariance of the tangent step at `point`; zero rows for held directions.
    ///
    /// It takes the whitening at its word. Multiply by `variance_factor` for the a-posteriori
    /// covariance, where sigma is only known up to a common factor.
    pub covariance: DMatrix<f64>,
    /// Whitened residuals at `point`, in the problem's order, before any robust weight.
    pub residuals: DVector<f64>,
    /// Robust weight `ρ'` of each residual, 1 where no robust loss applies.
    pub weights: DVector<f64>,
    /// Residuals used minus free directions.
    pub degrees_of_freedom: usize,
    /// `Σ w r² / degrees_of_freedom`; near 1 when the whitening is honest.
    ///
    /// `None` when there is no redundancy.
    pub variance_factor: Option<f64>,
    /// How the estimate was reached.
    pub report: Report,
}

impl<Point> Solution<Point> {
    /// A-priori standard uncertainty of each tangent direction; zero where held.
    #[must_use]
    pub fn standard_uncertainties(&self) -> DVector<f64> {
        self.covariance.diagonal().map(f64::sqrt)
    }
}
