//! Prior knowledge as further residual rows.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::{Problem, SolveError};

/// What is known of some functions of the point before any data: mean and uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior {
    /// What is expected.
    pub mean: DVector<f64>,
    /// Covariance about `mean`.
    pub covariance: DMatrix<f64>,
}

impl Prior {
    /// Independent quantities with their standard uncertainties.
    ///
    /// A missing standard uncertainty counts as NaN, which [`WithPrior::new`] rejects.
    #[must_use]
    pub fn independent(mean: &[f64], sigma: &[f64]) -> Self {
        let variance = |i: usize| sigma.get(i).map_or(f64::NAN, |s| s * s);
        Self {
            mean: DVector::from_row_slice(mean),
            covariance: DMatrix::from_diagonal(&DVector::from_fn(mean.len(), |i, _| variance(i))),
        }
    }
}

/// A problem whose last rows are a [`Prior`].
///
/// `quantity` says what the prior is about: it returns the quantities at a point and their
/// derivative by the tangent step, `prior rows × tangent_dim`. For a vector and its leading
/// directions that is the vector itself and an identity; for a pose near its mean, the
/// logarithm of their difference and the inverse of the exponential's Jacobian.
#[derive(Clone, Debug)]
pub struct WithPrior<'a, P, F> {
    problem: &'a P,
    quantity: F,
    mean: DVector<f64>,
    factor: Cholesky<f64, Dyn>,
}

impl<'a, P, F> WithPrior<'a, P, F>
where
    P: Problem,
    F: Fn(&P::Point) -> (DVector<f64>, DMatrix<f64>),
{
    /// Appends `prior` to the rows of `problem`.
    ///
    /// # Errors
    ///
    /// [`SolveError::InvalidPrior`] when the covariance is not positive definite.
    pub fn new(problem: &'a P, prior: Prior, quantity: F) -> Result<Self, SolveError<P::Point>> {
        let n = prior.mean.len();
        let factor = Some(prior.covariance)
            .filter(|c| c.shape() == (n, n) && c.iter().all(|v| v.is_finite()))
            .and_then(Cholesky::new)
            .ok_or(SolveError::InvalidPrior { row: 0, variance: f64::NAN })?;
        Ok(Self { problem, quantity, mean: prior.mean, factor })
    }
}

impl<P, F> Problem for WithPrior<'_, P, F>
where
    P: Problem,
    F: Fn(&P::Point) -> (DVector<f64>, DMatrix<f64>),
{
    type Point = P::Point;

    fn residual_count(&self) -> usize {
        self.problem.residual_count() + self.mean.len()
    }

    fn tangent_dim(&self) -> usize {
        self.problem.tangent_dim()
    }

    fn residuals(&self, at: &Self::Point, out: &mut DVector<f64>) {
        let n = self.problem.residual_count();
        let mut rows = DVector::zeros(n);
        self.problem.residuals(at, &mut rows);
        out.rows_mut(0, n).copy_from(&rows);
        let mut tail = (self.quantity)(at).0 - &self.mean;
        self.factor.l_dirty().solve_lower_triangular_mut(&mut tail);
        out.rows_mut(n, self.mean.len()).copy_from(&tail);
    }

    fn jacobian(&self, at: &Self::Point, out: &mut DMatrix<f64>) {
        let n = self.problem.residual_count();
        let mut rows = DMatrix::zeros(n, self.tangent_dim());
        self.problem.jacobian(at, &mut rows);
        out.rows_mut(0, n).copy_from(&rows);
        let mut tail = (self.quantity)(at).1;
        self.factor.l_dirty().solve_lower_triangular_mut(&mut tail);
        out.rows_mut(n, self.mean.len()).copy_from(&tail);
    }

    fn retract(&self, at: &Self::Point, step: &DVector<f64>) -> Self::Point {
        self.problem.retract(at, step)
    }

    fn parameter_name(&self, index: usize) -> String {
        self.problem.parameter_name(index)
    }
}
