//! A residual that is looked through for the clearest of many like effects.

use nalgebra::{DMatrix, DVector};

use crate::algebra::basis::{Basis, NEW_DIRECTION};
use crate::algebra::f_tail::chance_to_explain;
use crate::count::count;
use crate::{Model, Role, State, whole_tangent};

/// Share of a column's length below which what is left of it is round-off.
const TAKEN: f64 = 1e-6;
/// Chance that readings that show nothing of the sort offer one.
pub(crate) const FALSE_ALARM: f64 = 0.01;

/// The declared model, and the effects that are in it, at their solution: whitened, without the
/// observations that are only judged.
pub(crate) struct LookedThrough {
    rows: Vec<usize>,
    sigma: Vec<f64>,
    /// Orthonormal basis of the fitted parameters' columns.
    basis: DMatrix<f64>,
    /// Residual without what the basis explains.
    residual: DVector<f64>,
}

impl LookedThrough {
    /// An effect is in the model where one of its amplitudes at `at` is not zero.
    pub(crate) fn of(model: &dyn Model, at: &State) -> Self {
        let layout = &model.declared().layout;
        let is_fitted = |row: &usize| {
            let group = layout.observations[layout.rows[*row].observation];
            layout.groups[group].role != Role::Check
        };
        let rows: Vec<usize> = (0..layout.rows.len()).filter(is_fitted).collect();
        let sigma: Vec<f64> = rows.iter().map(|&row| layout.rows[row].sigma).collect();
        let whitened = |m: DMatrix<f64>| whitened(m.select_rows(&rows), &sigma);
        // What was found may be a part of what the base parameters do.
        let basis = Basis::of(&whitened(fitted_columns(model, at)), NEW_DIRECTION).matrix();
        let residual = model.residuals(at);
        let residual = whitened(DMatrix::from_column_slice(residual.len(), 1, residual.as_slice()));
        let residual = residual.column(0) - &basis * basis.tr_mul(&residual.column(0));
        Self { rows, sigma, basis, residual }
    }

    /// Rows of the layout that are looked at.
    pub(crate) fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// What is left of each, whitened.
    pub(crate) fn values(&self) -> &DVector<f64> {
        &self.residual
    }

    /// Columns of these rows, whitened.
    pub(crate) fn whitened(&self, tangent: DMatrix<f64>) -> DMatrix<f64> {
        whitened(tangent, &self.sigma)
    }

    /// What the fitted parameters leave of whitened columns.
    pub(crate) fn left_of(&self, tangent: DMatrix<f64>) -> DMatrix<f64> {
        let taken = &self.basis * self.basis.tr_mul(&tangent);
        tangent - taken
    }

    /// An orthonormal basis of what the fitted parameters leave of an effect; `None` where they take
    /// all of it.
    pub(crate) fn left_of_effect(
        &self,
        model: &dyn Model,
        at: &State,
        effect: usize,
    ) -> Option<DMatrix<f64>> {
        let tangent = self.whitened(whole_tangent(model, at, effect).select_rows(&self.rows));
        let left = self.left_of(tangent.clone());
        let mut kept = Basis::empty(left.nrows());
        for (column, whole) in left.column_iter().zip(tangent.column_iter()) {
            kept.push(&kept.reject(&column.into_owned()), whole.norm(), TAKEN);
        }
        (kept.dim() > 0).then(|| kept.matrix())
    }

    /// The same with more in the model, of which `left` is an orthonormal basis.
    pub(crate) fn beside(&self, left: &DMatrix<f64>) -> Self {
        let columns: Vec<_> = self.basis.column_iter().chain(left.column_iter()).collect();
        Self {
            rows: self.rows.clone(),
            sigma: self.sigma.clone(),
            basis: DMatrix::from_columns(&columns),
            residual: &self.residual - left * left.tr_mul(&self.residual),
        }
    }

    /// The sums over no rows of so many columns.
    pub(crate) fn nothing(&self, columns: usize) -> Sums {
        Sums {
            gram: DMatrix::zeros(columns, columns),
            across: DMatrix::zeros(self.basis.ncols(), columns),
            score: DVector::zeros(columns),
        }
    }

    /// Amplitudes of such columns; `None` where these depend on each other.
    pub(crate) fn amplitudes(&self, left: &DMatrix<f64>) -> Option<DVector<f64>> {
        Some(left.tr_mul(left).cholesky()?.solve(&left.tr_mul(&self.residual)))
    }

    /// What such columns take of the sum of squares; `None` where they depend on each other.
    pub(crate) fn explained(&self, left: &DMatrix<f64>) -> Option<f64> {
        Some(left.tr_mul(&self.residual).dot(&self.amplitudes(left)?))
    }

    /// Chance that white noise gives so many columns as much.
    pub(crate) fn p_value(&self, explained: f64, columns: usize) -> f64 {
        self.p_value_of_more(explained, columns, explained)
    }

    /// Mean square of what is left for each degree of freedom, with so many columns that explain so much.
    pub(crate) fn variance_beside(&self, explained: f64, columns: usize) -> f64 {
        let dof = self.residual.len().saturating_sub(self.basis.ncols() + columns);
        (self.residual.norm_squared() - explained).max(0.0) / count(dof.max(1))
    }

    /// Chance that white noise gives so many columns more as much, of all that is explained.
    pub(crate) fn p_value_of_more(&self, more: f64, columns: usize, explained: f64) -> f64 {
        let dof = self.residual.len().saturating_sub(self.basis.ncols() + columns);
        let left = (self.residual.norm_squared() - explained).max(0.0);
        chance_to_explain(more / left, columns, dof)
    }
}

/// Products of columns that are zero but in some rows: with each other, with the basis, and with the
/// residual.
#[derive(Clone, Debug)]
pub(crate) struct Sums {
    gram: DMatrix<f64>,
    across: DMatrix<f64>,
    score: DVector<f64>,
}

impl Sums {
    /// One row more, of whitened columns.
    pub(crate) fn add(&mut self, of: &LookedThrough, row: usize, columns: &DMatrix<f64>) {
        let values = columns.row(row).transpose();
        self.gram.ger(1.0, &values, &values, 1.0);
        self.across.ger(1.0, &of.basis.row(row).transpose(), &values, 1.0);
        self.score.axpy(of.residual[row], &values, 1.0);
    }

    /// The sums over those of its rows that are not in others.
    pub(crate) fn less(&self, others: &Self) -> Self {
        Self {
            gram: &self.gram - &others.gram,
            across: &self.across - &others.across,
            score: &self.score - &others.score,
        }
    }

    /// [`LookedThrough::explained`] of the columns.
    pub(crate) fn explained(&self) -> Option<f64> {
        let left = &self.gram - self.across.tr_mul(&self.across);
        Some(self.score.dot(&left.cholesky()?.solve(&self.score)))
    }
}

/// The columns of the base parameters, and of the amplitudes that are not zero.
fn fitted_columns(model: &dyn Model, at: &State) -> DMatrix<f64> {
    let mut columns: Vec<DVector<f64>> =
        model.base_jacobian(at).column_iter().map(nalgebra::Matrix::into_owned).collect();
    for (effect, amplitudes) in at.amplitudes.iter().enumerate() {
        if at.has(effect) {
            let tangent = whole_tangent(model, at, effect);
            let fitted = tangent.column_iter().zip(amplitudes).filter(|(_, a)| **a != 0.0);
            columns.extend(fitted.map(|(column, _)| column.into_owned()));
        }
    }
    if columns.is_empty() {
        return DMatrix::zeros(model.declared().layout.rows.len(), 0);
    }
    DMatrix::from_columns(&columns)
}

fn whitened(mut columns: DMatrix<f64>, sigma: &[f64]) -> DMatrix<f64> {
    columns.row_iter_mut().zip(sigma).for_each(|(mut row, s)| row /= *s);
    columns
}
