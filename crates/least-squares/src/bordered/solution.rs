use super::BorderedPoint;
use crate::Report;

/// A converged estimate of full rank; its uncertainty is a [`BorderedCovariance`].
///
/// [`BorderedCovariance`]: super::BorderedCovariance
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BorderedSolution {
    /// The estimate.
    pub point: BorderedPoint,
    /// Residuals used minus free directions.
    pub degrees_of_freedom: usize,
    /// `Σ w r² / degrees_of_freedom`; near 1 when the whitening is honest.
    ///
    /// `None` when there is no redundancy.
    pub variance_factor: Option<f64>,
    /// How the estimate was reached.
    ///
    /// `gradient` is the correlation of the residual with all columns together, judged by how far
    /// the last step missed the cost that it promised; `condition` is a lower bound from the
    /// pivots of the elimination, infinite where damping hides them.
    pub report: Report,
}
