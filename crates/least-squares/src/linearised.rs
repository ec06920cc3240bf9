//! A problem at one point: residuals, robust weights and the Jacobian of the free directions.

use nalgebra::{DMatrix, DVector};

use crate::qr::dot;
use crate::{Options, Problem, SolveError};

/// Residuals at a point with what the robust losses make of them.
#[derive(Clone, Debug)]
pub(crate) struct Evaluated {
    /// As the problem gives them.
    pub(crate) residuals: DVector<f64>,
    /// `√ρ'` per row.
    pub(crate) root_weights: DVector<f64>,
    /// `½ Σ ρ`; not finite where a residual is not.
    pub(crate) cost: f64,
}

impl Evaluated {
    pub(crate) fn new(rows: usize) -> Self {
        Self {
            residuals: DVector::zeros(rows),
            root_weights: DVector::repeat(rows, 1.0),
            cost: f64::INFINITY,
        }
    }

    pub(crate) fn fill<P: Problem>(&mut self, problem: &P, at: &P::Point, options: &Options) {
        problem.residuals(at, &mut self.residuals);
        let mut twice_cost = self.residuals.norm_squared();
        if !options.robust.is_empty() {
            self.root_weights.fill(1.0);
            // Not all squares less what the losses take off them: beside an outlier that
            // difference would hide the cost of all other rows in its rounding.
            let is_plain = |row: &usize| !options.robust.iter().any(|r| r.rows.contains(row));
            let plain = (0..self.residuals.len()).filter(is_plain);
            twice_cost = plain.map(|row| self.residuals[row].powi(2)).sum();
        }
        for robust in &options.robust {
            let end = robust.rows.end.min(self.residuals.len());
            let mut first = robust.rows.start;
            while first < end {
                let count = robust.block_rows.min(end - first);
                let s = self.residuals.rows(first, count).norm_squared();
                let (rho, weight) = robust.loss.evaluate(s);
                twice_cost += rho;
                self.root_weights.rows_mut(first, count).fill(weight.sqrt());
                first += count;
            }
        }
        self.cost = 0.5 * twice_cost;
    }
}

/// Whitened, robustly weighted rows and their derivative by the free directions.
#[derive(Clone, Debug)]
pub(crate) struct Linearised {
    /// Tangent directions that may move, in order.
    pub(crate) free: Vec<usize>,
    pub(crate) evaluated: Evaluated,
    /// `√w r`.
    pub(crate) weighted: DVector<f64>,
    /// `√w J`, free columns only.
    pub(crate) jacobian: DMatrix<f64>,
    /// Lengths of the columns of `jacobian`.
    pub(crate) column_norms: DVector<f64>,
    /// As the problem gives it.
    full: DMatrix<f64>,
}

/// An entry of the Jacobian that is infinite or NaN.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NonFinite {
    row: usize,
    column: usize,
    value: f64,
}

impl<Point> From<NonFinite> for SolveError<Point> {
    fn from(NonFinite { row, column, value }: NonFinite) -> Self {
        Self::NonFiniteJacobian { row, column, value }
    }
}

impl Linearised {
    /// Evaluates residuals and leaves the Jacobian for [`Linearised::differentiate`].
    pub(crate) fn evaluate<P: Problem>(
        problem: &P,
        at: &P::Point,
        options: &Options,
    ) -> Result<Self, SolveError<P::Point>> {
        let free = free_directions(problem, options)?;
        let (rows, columns) = (problem.residual_count(), problem.tangent_dim());
        let mut evaluated = Evaluated::new(rows);
        evaluated.fill(problem, at, options);
        if !evaluated.cost.is_finite() {
            // Finite residuals whose squares overflow count as infinite.
            let residuals = &evaluated.residuals;
            let row = residuals.iter().position(|r| !(r * r).is_finite());
            let row = row.unwrap_or_else(|| residuals.iamax());
            return Err(SolveError::NonFiniteResidual { row, value: residuals[row] });
        }
        Ok(Self {
            weighted: DVector::zeros(rows),
            jacobian: DMatrix::zeros(rows, free.len()),
            column_norms: DVector::zeros(free.len()),
            full: DMatrix::zeros(rows, columns),
            free,
            evaluated,
        })
    }

    /// Brings the Jacobian up to date with `evaluated`, which belongs to `at`.
    pub(crate) fn differentiate<P: Problem>(
        &mut self,
        problem: &P,
        at: &P::Point,
    ) -> Result<(), NonFinite> {
        self.full.fill(0.0);
        problem.jacobian(at, &mut self.full);
        let weights = &self.evaluated.root_weights;
        self.weighted.zip_zip_apply(&self.evaluated.residuals, weights, |out, r, w| {
            *out = w * r;
        });
        for (k, &column) in self.free.iter().enumerate() {
            let mut out = self.jacobian.column_mut(k);
            out.zip_zip_apply(&self.full.column(column), weights, |out, d, w| {
                *out = w * d;
            });
            self.column_norms[k] = dot(out.as_slice(), out.as_slice()).sqrt();
            if !self.column_norms[k].is_finite() {
                let entries = self.full.column(column);
                let row = entries.iter().position(|v| !(v * v).is_finite());
                let row = row.unwrap_or_else(|| entries.iamax());
                return Err(NonFinite { row, column, value: entries[row] });
            }
        }
        Ok(())
    }

    /// Largest correlation of a free column with the residual, 0 to 1.
    pub(crate) fn gradient_correlation(&self) -> f64 {
        let weighted = self.weighted.as_slice();
        let norm = dot(weighted, weighted).sqrt();
        if norm == 0.0 {
            return 0.0;
        }
        let correlation = |k: usize| {
            let length = self.column_norms[k];
            let projection = dot(self.jacobian.column(k).as_slice(), weighted);
            if length > 0.0 { (projection / length / norm).abs() } else { 0.0 }
        };
        (0..self.free.len()).map(correlation).fold(0.0, f64::max)
    }

    pub(crate) fn tangent_dim(&self) -> usize {
        self.full.ncols()
    }

    /// Writes a step of the free directions into one of all directions.
    pub(crate) fn spread(&self, step: &DVector<f64>, out: &mut DVector<f64>) {
        for (k, &index) in self.free.iter().enumerate() {
            out[index] = step[k];
        }
    }

    /// Rows that count at all.
    pub(crate) fn residuals_used(&self) -> usize {
        self.evaluated.root_weights.iter().filter(|w| **w > 0.0).count()
    }

    pub(crate) fn degrees_of_freedom(&self) -> usize {
        self.residuals_used().saturating_sub(self.free.len())
    }

    pub(crate) fn variance_factor(&self) -> Option<f64> {
        let degrees_of_freedom = self.degrees_of_freedom();
        #[expect(clippy::cast_precision_loss, reason = "row counts are far below 2^53")]
        (degrees_of_freedom > 0).then(|| self.weighted.norm_squared() / degrees_of_freedom as f64)
    }
}

/// Checks the options against the problem and lists the directions that are not held.
fn free_directions<P: Problem>(
    problem: &P,
    options: &Options,
) -> Result<Vec<usize>, SolveError<P::Point>> {
    let tangent_dim = problem.tangent_dim();
    if let Some(&index) = options.held.iter().find(|&&i| i >= tangent_dim) {
        return Err(SolveError::DirectionOutOfRange { index, tangent_dim });
    }
    for (index, robust) in options.robust.iter().enumerate() {
        let (scale, block_rows) = (robust.loss.scale(), robust.block_rows);
        if !(scale > 0.0 && scale.is_finite()) || block_rows == 0 {
            return Err(SolveError::InvalidLoss { index, scale, block_rows });
        }
    }
    Ok((0..tangent_dim).filter(|i| !options.held.contains(i)).collect())
}
