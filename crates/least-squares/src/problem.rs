use std::any::Any;

use nalgebra::{DMatrix, DVector};

/// Residuals of a model against its data, over points that may live on a manifold.
///
/// Residuals are *whitened*: each divided by its standard uncertainty, so that the
/// covariance of the estimate comes out in the units of the parameters.
pub trait Problem {
    /// The estimate: a vector, a pose, or any mixture.
    type Point: Clone + 'static;

    /// Number of residuals.
    fn residual_count(&self) -> usize;

    /// Number of degrees of freedom of a step.
    fn tangent_dim(&self) -> usize;

    /// Writes the whitened residuals at `at`; `out` has `residual_count` rows.
    fn residuals(&self, at: &Self::Point, out: &mut DVector<f64>);

    /// Writes `∂r/∂ξ` at `ξ = 0` for the step `ξ` taken by [`Problem::retract`]; `out` is
    /// `residual_count × tangent_dim`.
    fn jacobian(&self, at: &Self::Point, out: &mut DMatrix<f64>);

    /// Moves `at` by the tangent step `step`.
    fn retract(&self, at: &Self::Point, step: &DVector<f64>) -> Self::Point;

    /// Whether `at` is a point of this problem: whether a vector has the right length.
    ///
    /// A start that is none is [`SolveError::InvalidStart`](crate::SolveError::InvalidStart)
    /// instead of a panic in [`Problem::residuals`]. Unless you write another rule, a `DVector` or
    /// a `Vec` has one number per degree of freedom, and any other type is taken as it is. Write
    /// one where a vector holds more numbers than a step, such as a unit quaternion.
    fn is_point(&self, at: &Self::Point) -> bool {
        let at: &dyn Any = at;
        let length = (at.downcast_ref::<DVector<f64>>().map(DVector::len))
            .or_else(|| at.downcast_ref::<Vec<f64>>().map(Vec::len));
        length.is_none_or(|length| length == self.tangent_dim())
    }

    /// Name of one tangent direction with its unit, for errors and reports.
    fn parameter_name(&self, index: usize) -> String {
        format!("parameter {index}")
    }
}
