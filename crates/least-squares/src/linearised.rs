//! A problem at one point: residuals, robust weights and the Jacobian of the free directions.

use nalgebra::{DMatrix, DVector};

use crate::covariance::Factored;
use crate::{Options, Problem, Report, SolveError};

/// Residuals at a point with what the robust losses make of them.
#[derive(Clone)]
pub(crate) struct Evaluated {
    /// As the problem gives them.
    pub(crate) residuals: DVector<f64>,
    /// `ρ'` per row.
    pub(crate) weights: DVector<f64>,
    /// `½ Σ ρ`.
    pub(crate) cost: f64,
}

impl Evaluated {
    pub(crate) fn zeros(rows: usize) -> Self {
        Self {
            residuals: DVector::zeros(rows),
            weights: DVector::repeat(rows, 1.0),
            cost: f64::INFINITY,
        }
    }

    /// Evaluates in place; the cost is not finite when a residual is not.
    pub(crate) fn fill<P: Problem>(&mut self, problem: &P, at: &P::Point, options: &Options) {
        problem.residuals(at, &mut self.residuals);
        if options.robust.is_empty() {
            self.cost = 0.5 * self.residuals.norm_squared();
            return;
        }
        let rows = self.residuals.len();
        self.weights.fill(1.0);
        let mut cost = self.residuals.norm_squared();
        for robust in &options.robust {
            let end = robust.rows.end.min(rows);
            let mut first = robust.rows.start.min(end);
            while first < end {
                let n = robust.block_rows.min(end - first);
                let s = self.residuals.rows(first, n).norm_squared();
                let (rho, weight) = robust.loss.evaluate(s);
                cost += rho - s;
                self.weights.rows_mut(first, n).fill(weight);
                first += n;
            }
        }
        self.cost = 0.5 * cost;
    }
}

pub(crate) struct Linearised {
    /// Tangent directions that may move, in order.
    pub(crate) free: Vec<usize>,
    pub(crate) tangent_dim: usize,
    pub(crate) evaluated: Evaluated,
    /// `√w r`.
    pub(crate) weighted: DVector<f64>,
    /// `√w J`, free columns only.
    pub(crate) jacobian: DMatrix<f64>,
    full: DMatrix<f64>,
}

impl Linearised {
    pub(crate) fn at<P: Problem>(
        problem: &P,
        at: &P::Point,
        options: &Options,
    ) -> Result<Self, SolveError<P::Point>> {
        let free = free_columns(problem, options)?;
        let (rows, tangent_dim) = (problem.residual_count(), problem.tangent_dim());
        let mut evaluated = Evaluated::zeros(rows);
        evaluated.fill(problem, at, options);
        if let Some(row) = evaluated.residuals.iter().position(|r| !r.is_finite()) {
            return Err(SolveError::NonFiniteResidual { row, value: evaluated.residuals[row] });
        }
        let mut linearised = Self {
            weighted: DVector::zeros(rows),
            jacobian: DMatrix::zeros(rows, free.len()),
            full: DMatrix::zeros(rows, tangent_dim),
            free,
            tangent_dim,
            evaluated,
        };
        linearised.linearise(problem, at)?;
        Ok(linearised)
    }

    /// Brings the Jacobian up to date with `evaluated`, which belongs to `at`.
    pub(crate) fn linearise<P: Problem>(
        &mut self,
        problem: &P,
        at: &P::Point,
    ) -> Result<(), SolveError<P::Point>> {
        self.full.fill(0.0);
        problem.jacobian(at, &mut self.full);
        for (k, &column) in self.free.iter().enumerate() {
            for row in 0..self.full.nrows() {
                let value = self.full[(row, column)];
                if !value.is_finite() {
                    return Err(SolveError::NonFiniteJacobian { row, column, value });
                }
                self.jacobian[(row, k)] = self.evaluated.weights[row].sqrt() * value;
            }
        }
        self.weighted.zip_zip_apply(
            &self.evaluated.residuals,
            &self.evaluated.weights,
            |out, r, w| {
                *out = w.sqrt() * r;
            },
        );
        Ok(())
    }

    /// Largest correlation of a free column with the residual.
    pub(crate) fn gradient_correlation(&self) -> f64 {
        let norm = self.weighted.norm();
        if norm == 0.0 {
            return 0.0;
        }
        self.jacobian
            .column_iter()
            .map(|c| (c.norm(), c.dot(&self.weighted)))
            .filter(|(length, _)| *length > 0.0)
            .map(|(length, dot)| (dot / (length * norm)).abs())
            .fold(0.0, f64::max)
    }

    /// Rows that count at all.
    pub(crate) fn used(&self) -> usize {
        self.evaluated.weights.iter().filter(|w| **w > 0.0).count()
    }

    pub(crate) fn degrees_of_freedom(&self) -> usize {
        self.used().saturating_sub(self.free.len())
    }

    pub(crate) fn variance_factor(&self) -> Option<f64> {
        let dof = self.degrees_of_freedom();
        #[expect(clippy::cast_precision_loss, reason = "row counts are far below 2^53")]
        (dof > 0).then(|| self.weighted.norm_squared() / dof as f64)
    }

    pub(crate) fn report(&self, factored: &Factored) -> Report {
        Report {
            termination: None,
            iterations: 0,
            residual_evaluations: 1,
            jacobian_evaluations: 1,
            initial_cost: self.evaluated.cost,
            final_cost: self.evaluated.cost,
            gradient: self.gradient_correlation(),
            rank: factored.rank,
            condition: factored.condition,
            residuals_given: self.evaluated.residuals.len(),
            residuals_used: self.used(),
            parameters: self.free.len(),
        }
    }
}

fn free_columns<P: Problem>(
    problem: &P,
    options: &Options,
) -> Result<Vec<usize>, SolveError<P::Point>> {
    let tangent_dim = problem.tangent_dim();
    if let Some(&index) = options.held.iter().find(|&&i| i >= tangent_dim) {
        return Err(SolveError::HeldOutOfRange { index, tangent_dim });
    }
    for (index, robust) in options.robust.iter().enumerate() {
        let (scale, block_rows) = (robust.loss.scale(), robust.block_rows);
        if !(scale > 0.0 && scale.is_finite()) || block_rows == 0 {
            return Err(SolveError::InvalidLoss { index, scale, block_rows });
        }
    }
    Ok((0..tangent_dim).filter(|i| !options.held.contains(i)).collect())
}
