//! Orthonormal bases built column by column, and what they leave of other columns.

use std::sync::Arc;

use faer::{MatMut, MatRef};
use nalgebra::{DMatrix, DVector, DVectorView};

use crate::algebra::product::{add_times, times, view};

/// Orthonormal columns spanning a subspace of ℝⁿ.
///
/// Gram-Schmidt, repeated where most of a column is taken away: orthogonal to round-off («twice is
/// enough», Daniel, Gragg, Kaufman and Stewart 1976; Giraud, Langou and Rozložník 2005). A basis with
/// further columns shares those that it began with.
#[derive(Clone, Debug)]
pub(crate) struct Basis {
    rows: usize,
    dim: usize,
    /// Column by column, those that are shared first.
    shared: Arc<Vec<f64>>,
    own: Vec<f64>,
}

/// Share of a column's norm below which it adds nothing to a basis: ten times the round-off of
/// a chain of a thousand operations.
pub(crate) const NEW_DIRECTION: f64 = 1e-10;

/// Columns that are added to a basis at a time.
const PANEL: usize = 16;

/// Share of its length below which a column has lost digits and is rejected anew.
const CANCELLED: f64 = 0.1;

impl Basis {
    pub(crate) fn empty(rows: usize) -> Self {
        Self { rows, dim: 0, shared: Arc::default(), own: Vec::new() }
    }

    /// Basis of the columns, leaving out those that keep less than `min_kept` of their norm.
    pub(crate) fn of(columns: &DMatrix<f64>, min_kept: f64) -> Self {
        let mut basis = Self::empty(columns.nrows());
        basis.extend(columns, min_kept);
        basis.shared = Arc::new(std::mem::take(&mut basis.own));
        basis
    }

    fn extend(&mut self, columns: &DMatrix<f64>, min_kept: f64) {
        self.own.reserve(columns.len());
        for start in (0..columns.ncols()).step_by(PANEL) {
            let panel = columns.columns(start, PANEL.min(columns.ncols() - start));
            let mut beside = panel.into_owned();
            self.take_away(0, beside.as_mut_slice());
            let before = self.dim;
            for (mut rest, whole) in beside.column_iter_mut().zip(panel.column_iter()) {
                let (left, rest) = (rest.norm(), rest.as_mut_slice());
                self.take_away(before, rest);
                if before > 0 && norm(rest) < CANCELLED * left {
                    self.take_away(0, rest);
                }
                self.push_rest(rest, whole.norm(), min_kept);
            }
        }
    }

    /// Adds what is new in `rest`, a column of norm `whole` from which something has been taken;
    /// false when less than `min_kept` of `whole` is new.
    pub(crate) fn push(&mut self, rest: &DVector<f64>, whole: f64, min_kept: f64) -> bool {
        let rest = self.reject(rest);
        self.push_rest(rest.as_slice(), whole, min_kept)
    }

    fn push_rest(&mut self, rest: &[f64], whole: f64, min_kept: f64) -> bool {
        let length = norm(rest);
        // `>` also turns away NaN and the zero column.
        let new = length > min_kept * whole && length > f64::MIN_POSITIVE;
        if new {
            self.own.extend(rest.iter().map(|v| v / length));
            self.dim += 1;
        }
        new
    }

    pub(crate) fn dim(&self) -> usize {
        self.dim
    }

    /// How many columns are shared.
    fn n_shared(&self) -> usize {
        self.shared.len() / self.rows.max(1)
    }

    fn column(&self, index: usize) -> DVectorView<'_, f64> {
        let (of, index) = match index.checked_sub(self.n_shared()) {
            Some(index) => (&self.own, index),
            None => (&*self.shared, index),
        };
        let start = index * self.rows;
        DVectorView::from_slice(&of[start..start + self.rows], self.rows)
    }

    /// The columns from `first` on that are shared, and the others.
    fn parts(&self, first: usize) -> [MatRef<'_, f64>; 2] {
        let shared = self.n_shared();
        let own = first.saturating_sub(shared);
        [(&self.shared[..], first.min(shared)), (&self.own[..], own)].map(|(values, first)| {
            let values = &values[first * self.rows..];
            let columns = values.len() / self.rows.max(1);
            MatRef::from_column_major_slice(values, self.rows, columns)
        })
    }

    /// Component of `x` orthogonal to the basis.
    pub(crate) fn reject(&self, x: &DVector<f64>) -> DVector<f64> {
        let mut rest = x.clone();
        self.take_away(0, rest.as_mut_slice());
        rest
    }

    /// [`Basis::reject`] of every column.
    pub(crate) fn reject_columns(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let mut rest = x.clone();
        self.take_away(0, rest.as_mut_slice());
        rest
    }

    /// Takes the basis from `first` on out of columns one after the other, again of those of which it takes most.
    fn take_away(&self, first: usize, columns: &mut [f64]) {
        if first == self.dim {
            return;
        }
        let rows = self.rows;
        let before: Vec<f64> = columns.chunks_exact(rows).map(norm).collect();
        self.take_out(first, columns);
        let lost = |(column, before): (&[f64], &f64)| norm(column) < CANCELLED * before;
        let lost: Vec<usize> = (columns.chunks_exact(rows).zip(&before).enumerate())
            .filter_map(|(c, column)| lost(column).then_some(c))
            .collect();
        let of = |c: usize| c * rows..(c + 1) * rows;
        let mut again: Vec<f64> = Vec::with_capacity(lost.len() * rows);
        for &c in &lost {
            again.extend_from_slice(&columns[of(c)]);
        }
        self.take_out(first, &mut again);
        for (&c, left) in lost.iter().zip(again.chunks_exact(rows)) {
            columns[of(c)].copy_from_slice(left);
        }
    }

    /// The same once.
    fn take_out(&self, first: usize, columns: &mut [f64]) {
        let width = columns.len() / self.rows;
        let mut columns = MatMut::from_column_major_slice_mut(columns, self.rows, width);
        let parts = self.parts(first);
        let along = parts.map(|part| times(part.transpose(), columns.as_ref()));
        for (part, along) in parts.into_iter().zip(&along) {
            add_times(columns.as_mut(), -1.0, part, view(along));
        }
    }

    /// The columns along the basis, `dim × columns`.
    pub(crate) fn along(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut along = DMatrix::zeros(self.dim, columns.ncols());
        let mut first = 0;
        for part in self.parts(0) {
            let own = times(part.transpose(), view(columns));
            along.rows_mut(first, own.nrows()).copy_from(&own);
            first += own.nrows();
        }
        along
    }

    /// Squared norm of the projection of `x` on the basis.
    pub(crate) fn explained(&self, x: &DVector<f64>) -> f64 {
        self.explained_from(0, x)
    }

    /// The same on the columns from `first` on.
    pub(crate) fn explained_from(&self, first: usize, x: &DVector<f64>) -> f64 {
        (first..self.dim).map(|index| self.column(index).dot(x).powi(2)).sum()
    }

    /// The given rows of [`Basis::matrix`].
    pub(crate) fn rows(&self, rows: &[usize]) -> DMatrix<f64> {
        self.rows_from(0, rows)
    }

    /// The same of the columns from `first` on.
    pub(crate) fn rows_from(&self, first: usize, rows: &[usize]) -> DMatrix<f64> {
        let mut some = DMatrix::zeros(rows.len(), self.dim - first);
        for (k, mut to) in some.column_iter_mut().enumerate() {
            let column = self.column(first + k);
            to.iter_mut().zip(rows).for_each(|(to, &row)| *to = column[row]);
        }
        some
    }

    /// Columns from `first` on, as a matrix.
    pub(crate) fn columns_from(&self, first: usize) -> DMatrix<f64> {
        let start = first * self.rows;
        let of_shared = self.shared.get(start..).unwrap_or_default();
        let of_own = &self.own[start.saturating_sub(self.shared.len())..];
        let values = of_shared.iter().chain(of_own).copied();
        DMatrix::from_iterator(self.rows, self.dim - first, values)
    }

    /// The basis as a matrix, `rows × dim`.
    pub(crate) fn matrix(&self) -> DMatrix<f64> {
        self.columns_from(0)
    }

    /// Both bases together; columns of `other` that are not new are left out.
    pub(crate) fn with(&self, other: &DMatrix<f64>, min_kept: f64) -> Self {
        let mut both = self.clone();
        both.extend(other, min_kept);
        both
    }
}

fn norm(column: &[f64]) -> f64 {
    DVectorView::from_slice(column, column.len()).norm()
}

/// Smallest cosine: near 1 when the smaller space lies inside the larger one.
pub(crate) fn smallest_cosine(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    if a.ncols() == 0 || b.ncols() == 0 {
        return 0.0;
    }
    (a.transpose() * b).singular_values().min().min(1.0)
}
