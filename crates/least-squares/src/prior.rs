//! Prior knowledge as further residual rows.

use nalgebra::{DMatrix, DVector};

use crate::{Problem, SolveError};

/// What is known of some quantities before any data: their mean and its uncertainty.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Prior {
    /// What is expected.
    pub mean: DVector<f64>,
    /// Covariance about `mean`.
    pub covariance: DMatrix<f64>,
}

impl Prior {
    /// Independent quantities, each given as mean and standard uncertainty.
    #[must_use]
    pub fn independent(mean_and_sigma: &[(f64, f64)]) -> Self {
        let n = mean_and_sigma.len();
        Self {
            mean: DVector::from_fn(n, |i, _| mean_and_sigma[i].0),
            covariance: DMatrix::from_diagonal(&DVector::from_fn(n, |i, _| {
                mean_and_sigma[i].1.powi(2)
            })),
        }
    }
}

/// A problem with a [`Prior`] as its last rows.
///
/// `quantity` says what the prior is about: at a point it returns the quantities, and their
/// derivative by the tangent step (`prior rows × tangent_dim`). For a pose near its mean these
/// are the logarithm of their difference and the inverse of the exponential's Jacobian; for
/// vectors see [`with_vector_prior`].
#[derive(Clone, Debug)]
pub struct WithPrior<'a, P, F> {
    problem: &'a P,
    quantity: F,
    mean: DVector<f64>,
    /// `L` of the covariance `L Lᵀ`; its inverse whitens.
    factor: DMatrix<f64>,
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
    /// [`SolveError::InvalidPrior`] when the mean is not finite, or the covariance is not a
    /// positive definite matrix of its size.
    pub fn new(problem: &'a P, prior: Prior, quantity: F) -> Result<Self, SolveError<P::Point>> {
        let Prior { mean, covariance } = prior;
        let factor = cholesky(&covariance, mean.len())?;
        match mean.iter().position(|m| !m.is_finite()) {
            Some(row) => Err(SolveError::InvalidPrior { row, variance: covariance[(row, row)] }),
            None => Ok(Self { problem, quantity, mean, factor }),
        }
    }
}

/// Appends a prior on some components of a point that is a plain vector.
///
/// # Errors
///
/// [`SolveError::DirectionOutOfRange`] when a direction does not exist, otherwise as
/// [`WithPrior::new`].
#[expect(clippy::type_complexity, reason = "a closure's type has no name of its own")]
pub fn with_vector_prior<'a, P: Problem<Point = DVector<f64>>>(
    problem: &'a P,
    directions: &[usize],
    prior: Prior,
) -> Result<
    WithPrior<'a, P, impl Fn(&DVector<f64>) -> (DVector<f64>, DMatrix<f64>) + Clone>,
    SolveError,
> {
    let tangent_dim = problem.tangent_dim();
    if let Some(&index) = directions.iter().find(|&&i| i >= tangent_dim) {
        return Err(SolveError::DirectionOutOfRange { index, tangent_dim });
    }
    if directions.len() != prior.mean.len() {
        return Err(SolveError::InvalidPrior { row: directions.len(), variance: f64::NAN });
    }
    let directions = directions.to_vec();
    let mut derivative = DMatrix::zeros(directions.len(), tangent_dim);
    for (row, &column) in directions.iter().enumerate() {
        derivative[(row, column)] = 1.0;
    }
    let quantity = move |point: &DVector<f64>| {
        (DVector::from_fn(directions.len(), |i, _| point[directions[i]]), derivative.clone())
    };
    WithPrior::new(problem, prior, quantity)
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

    fn is_point(&self, at: &P::Point) -> bool {
        self.problem.is_point(at)
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
        self.factor.solve_lower_triangular_mut(&mut tail);
        out.rows_mut(n, self.mean.len()).copy_from(&tail);
    }

    fn jacobian(&self, at: &Self::Point, out: &mut DMatrix<f64>) {
        let n = self.problem.residual_count();
        let mut rows = DMatrix::zeros(n, self.tangent_dim());
        self.problem.jacobian(at, &mut rows);
        out.rows_mut(0, n).copy_from(&rows);
        let mut tail = (self.quantity)(at).1;
        self.factor.solve_lower_triangular_mut(&mut tail);
        out.rows_mut(n, self.mean.len()).copy_from(&tail);
    }

    fn retract(&self, at: &Self::Point, step: &DVector<f64>) -> Self::Point {
        self.problem.retract(at, step)
    }

    fn parameter_name(&self, index: usize) -> String {
        self.problem.parameter_name(index)
    }
}

/// Lower factor of an `n × n` covariance, or the first row that the rows before determine.
fn cholesky<Point>(covariance: &DMatrix<f64>, n: usize) -> Result<DMatrix<f64>, SolveError<Point>> {
    if covariance.shape() != (n, n) {
        return Err(SolveError::InvalidPrior { row: covariance.nrows(), variance: f64::NAN });
    }
    let mut lower = DMatrix::zeros(n, n);
    for row in 0..n {
        for column in 0..row {
            let known: f64 = (0..column).map(|k| lower[(row, k)] * lower[(column, k)]).sum();
            lower[(row, column)] = (covariance[(row, column)] - known) / lower[(column, column)];
        }
        let known: f64 = (0..row).map(|k: usize| lower[(row, k)] * lower[(row, k)]).sum();
        let variance: f64 = covariance[(row, row)] - known;
        if !(variance > 0.0 && variance.is_finite()) {
            return Err(SolveError::InvalidPrior { row, variance });
        }
        lower[(row, row)] = variance.sqrt();
    }
    Ok(lower)
}
