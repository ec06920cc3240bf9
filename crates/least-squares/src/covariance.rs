//! Covariance from a pivoted QR factorisation of the whitened, column-scaled Jacobian.

use faer::MatRef;
use nalgebra::{DMatrix, DVector};

use crate::linearised::Linearised;
use crate::null_space::free_directions;
use crate::{FreeDirection, Options, Problem, SolveError};

/// Uncertainty of a point, as its data and their whitening determine it.
#[derive(Clone, Debug, PartialEq)]
pub struct Covariance {
    /// A-priori covariance of the tangent step; zero rows and columns for held directions.
    ///
    /// Multiply by `variance_factor` for the a-posteriori covariance.
    pub matrix: DMatrix<f64>,
    /// Condition number of the whitened, column-scaled Jacobian.
    pub condition: f64,
    /// Residuals used minus free directions.
    pub degrees_of_freedom: usize,
    /// `Σ w r² / degrees_of_freedom`; `None` when there is no redundancy.
    pub variance_factor: Option<f64>,
}

/// Covariance of the tangent step at a point that some other means has found.
///
/// # Errors
///
/// [`SolveError::Unobservable`] when a direction is free, and the errors of bad input;
/// [`SolveError::NotConverged`] never.
pub fn covariance<P: Problem>(
    problem: &P,
    at: &P::Point,
    options: &Options,
) -> Result<Covariance, SolveError<P::Point>> {
    let linearised = Linearised::at(problem, at, options)?;
    let factored = Factored::new(&linearised, options.rank_tolerance);
    if factored.rank < linearised.free.len() {
        return Err(SolveError::Unobservable {
            directions: factored.free_directions(problem, &linearised),
            best: Box::new(at.clone()),
            report: Box::new(linearised.report(&factored)),
        });
    }
    Ok(Covariance {
        matrix: factored.covariance(&linearised),
        condition: factored.condition,
        degrees_of_freedom: linearised.degrees_of_freedom(),
        variance_factor: linearised.variance_factor(),
    })
}

/// `J S⁻¹ P = Q R` with unit columns in `J S⁻¹`, and the singular values of `R`.
pub(crate) struct Factored {
    scale: DVector<f64>,
    order: Vec<usize>,
    r: DMatrix<f64>,
    /// Right singular vectors of `J S⁻¹` whose singular value is nought.
    null_space: DMatrix<f64>,
    pub(crate) rank: usize,
    pub(crate) condition: f64,
}

impl Factored {
    pub(crate) fn new(linearised: &Linearised, rank_tolerance: f64) -> Self {
        let jacobian = &linearised.jacobian;
        let (rows, columns) = jacobian.shape();
        let scale = DVector::from_iterator(
            columns,
            jacobian.column_iter().map(|c| if c.norm() > 0.0 { c.norm() } else { 1.0 }),
        );
        // Rows of zeros make a wide matrix square; they change neither R nor the null space.
        let mut scaled = jacobian.clone().resize_vertically(rows.max(columns), 0.0);
        for (mut column, s) in scaled.column_iter_mut().zip(scale.iter()) {
            column /= *s;
        }
        let qr = MatRef::from_column_major_slice(scaled.as_slice(), scaled.nrows(), columns)
            .col_piv_qr();
        let r =
            DMatrix::from_fn(columns, columns, |i, j| if i <= j { qr.R()[(i, j)] } else { 0.0 });
        let order = qr.P().arrays().0.to_vec();

        let svd = r.clone().svd(false, true);
        let v_t = svd.v_t.expect("requested");
        let largest = svd.singular_values.max();
        let free: Vec<usize> =
            (0..columns).filter(|&i| svd.singular_values[i] <= rank_tolerance * largest).collect();
        let mut null_space = DMatrix::zeros(columns, free.len());
        for (k, &i) in free.iter().enumerate() {
            for (j, &column) in order.iter().enumerate() {
                null_space[(column, k)] = v_t[(i, j)];
            }
        }
        let condition = if columns == 0 { 1.0 } else { largest / svd.singular_values.min() };
        Self { scale, order, r, rank: columns - free.len(), null_space, condition }
    }

    pub(crate) fn covariance(&self, linearised: &Linearised) -> DMatrix<f64> {
        let columns = self.order.len();
        let mut inverse = DMatrix::identity(columns, columns);
        self.r.solve_upper_triangular_mut(&mut inverse);
        let pivoted = &inverse * inverse.transpose();
        let mut covariance = DMatrix::zeros(linearised.tangent_dim, linearised.tangent_dim);
        for (i, &a) in self.order.iter().enumerate() {
            for (j, &b) in self.order.iter().enumerate() {
                covariance[(linearised.free[a], linearised.free[b])] =
                    pivoted[(i, j)] / (self.scale[a] * self.scale[b]);
            }
        }
        covariance
    }

    pub(crate) fn free_directions<P: Problem>(
        &self,
        problem: &P,
        linearised: &Linearised,
    ) -> Vec<FreeDirection> {
        free_directions(&self.null_space, &self.scale, &linearised.free, problem)
    }
}
