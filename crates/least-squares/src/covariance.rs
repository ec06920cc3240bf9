//! Covariance from a pivoted QR factorisation of the whitened, column-scaled Jacobian.

use nalgebra::{DMatrix, DVector};

use crate::factorisation::{pivoted_qr, singular_values};
use crate::linearised::Linearised;
use crate::null_space::free_directions;
use crate::search::Counts;
use crate::{FreeDirection, Options, Problem, Report, SolveError};

/// Uncertainty of a point, as its data and their whitening determine it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
/// never [`SolveError::NotConverged`] or [`SolveError::Stalled`].
pub fn covariance<P: Problem>(
    problem: &P,
    at: &P::Point,
    options: &Options,
) -> Result<Covariance, SolveError<P::Point>> {
    let mut linearised = Linearised::evaluate(problem, at, options)?;
    linearised.differentiate(problem, at)?;
    let factored = Factored::new(&linearised, options.rank_tolerance);
    if !factored.is_full_rank() {
        let counts = Counts { searches: 0, iterations: 0, residuals: 1, jacobians: 1 };
        let cost = linearised.evaluated.cost;
        return Err(SolveError::Unobservable {
            directions: factored.free_directions(problem, &linearised),
            best: Box::new(at.clone()),
            report: Box::new(report(&linearised, &factored, counts, cost)),
        });
    }
    Ok(Covariance {
        matrix: factored.covariance(&linearised),
        condition: factored.condition,
        degrees_of_freedom: linearised.degrees_of_freedom(),
        variance_factor: linearised.variance_factor(),
    })
}

/// `J S⁻¹ P = Q R` with unit columns in `J S⁻¹`, and what the singular values of `R` say.
pub(crate) struct Factored {
    /// Column lengths `S`; 1 for a column of zeros.
    scale: DVector<f64>,
    /// Column of `J` for each column of `R`.
    order: Vec<usize>,
    r: DMatrix<f64>,
    /// Right singular vectors of `J S⁻¹` whose singular value counts as nought, weakest last.
    null_space: DMatrix<f64>,
    pub(crate) condition: f64,
}

impl Factored {
    pub(crate) fn new(linearised: &Linearised, rank_tolerance: f64) -> Self {
        let jacobian = &linearised.jacobian;
        let (rows, columns) = jacobian.shape();
        let scale = linearised.column_norms.map(|s| if s > 0.0 { s } else { 1.0 });
        // Rows of zeros make a wide matrix square; they change neither R nor the null space.
        let mut scaled = DMatrix::zeros(rows.max(columns), columns);
        for (k, s) in scale.iter().enumerate() {
            scaled.view_mut((0, k), (rows, 1)).zip_apply(&jacobian.column(k), |out, v| {
                *out = v / s;
            });
        }
        let (r, order) = pivoted_qr(&scaled);
        let (singular_values, v_t) = singular_values(&r);
        let largest = singular_values.iter().copied().fold(0.0, f64::max);
        let smallest = singular_values.iter().copied().fold(f64::INFINITY, f64::min);
        let weak: Vec<usize> = (0..columns)
            .filter(|&i| singular_values[i] <= rank_tolerance * largest || largest == 0.0)
            .collect();
        let mut null_space = DMatrix::zeros(columns, weak.len());
        for (k, &i) in weak.iter().enumerate() {
            for (j, &column) in order.iter().enumerate() {
                null_space[(column, k)] = v_t[(i, j)];
            }
        }
        let condition = if columns == 0 { 1.0 } else { largest / smallest };
        Self { scale, order, r, null_space, condition }
    }

    pub(crate) fn rank(&self) -> usize {
        self.order.len() - self.null_space.ncols()
    }

    pub(crate) fn is_full_rank(&self) -> bool {
        self.null_space.ncols() == 0
    }

    /// `S⁻¹ P R⁻¹ R⁻ᵀ Pᵀ S⁻¹`, held directions filled in with zeros.
    pub(crate) fn covariance(&self, linearised: &Linearised) -> DMatrix<f64> {
        let columns = self.order.len();
        let mut inverse = DMatrix::identity(columns, columns);
        self.r.solve_upper_triangular_mut(&mut inverse);
        let pivoted = &inverse * inverse.transpose();
        let dim = linearised.tangent_dim();
        let mut covariance = DMatrix::zeros(dim, dim);
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
        let name = |index| problem.parameter_name(index);
        free_directions(
            &self.null_space,
            &self.scale,
            &linearised.free,
            linearised.tangent_dim(),
            name,
        )
    }

    /// Free directions as shares of unit columns and as steps, weakest first.
    pub(crate) fn weakest_directions(
        &self,
    ) -> impl Iterator<Item = (DVector<f64>, DVector<f64>)> + '_ {
        self.null_space.column_iter().rev().map(|share| {
            let share = share.into_owned();
            let step = share.component_div(&self.scale);
            (share, step)
        })
    }
}

/// How a search went, and what it left at its end.
pub(crate) fn report(
    at: &Linearised,
    factored: &Factored,
    counts: Counts,
    initial_cost: f64,
) -> Report {
    Report {
        termination: None,
        searches: counts.searches,
        iterations: counts.iterations,
        residual_evaluations: counts.residuals,
        jacobian_evaluations: counts.jacobians,
        initial_cost,
        final_cost: at.evaluated.cost,
        gradient: at.gradient_correlation(),
        rank: factored.rank(),
        condition: factored.condition,
        residuals_given: at.evaluated.residuals.len(),
        residuals_used: at.residuals_used(),
        parameters: at.free.len(),
    }
}
