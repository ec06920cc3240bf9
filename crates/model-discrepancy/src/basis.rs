//! Orthonormal bases built column by column, and what they leave of other columns.

use nalgebra::{DMatrix, DVector};

/// Orthonormal columns spanning a subspace of ℝⁿ.
///
/// Modified Gram-Schmidt, repeated once: orthogonal to round-off («twice is enough»,
/// Giraud, Langou and Rozložník 2005).
#[derive(Clone, Debug)]
pub(crate) struct Basis {
    rows: usize,
    vectors: Vec<DVector<f64>>,
}

impl Basis {
    pub(crate) fn empty(rows: usize) -> Self {
        Self { rows, vectors: Vec::new() }
    }

    /// Basis of the columns, leaving out those that keep less than `min_kept` of their norm.
    pub(crate) fn of(columns: &DMatrix<f64>, min_kept: f64) -> Self {
        let mut basis = Self::empty(columns.nrows());
        for column in columns.column_iter() {
            basis.push(&column.into_owned(), min_kept);
        }
        basis
    }

    /// Adds what is new in `column`; false when less than `min_kept` of its norm is new.
    pub(crate) fn push(&mut self, column: &DVector<f64>, min_kept: f64) -> bool {
        let before = column.norm();
        let rest = self.reject(column);
        let after = rest.norm();
        // `>` also turns away NaN and the zero column.
        let new = after > min_kept * before && after > f64::MIN_POSITIVE;
        if new {
            self.vectors.push(rest / after);
        }
        new
    }

    pub(crate) fn dim(&self) -> usize {
        self.vectors.len()
    }

    /// Component of `x` orthogonal to the basis.
    pub(crate) fn reject(&self, x: &DVector<f64>) -> DVector<f64> {
        let mut rest = x.clone();
        for _ in 0..2 {
            for q in &self.vectors {
                let along = q.dot(&rest);
                rest.axpy(-along, q, 1.0);
            }
        }
        rest
    }

    /// [`Basis::reject`] of every column.
    pub(crate) fn reject_columns(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let columns: Vec<_> = x.column_iter().map(|c| self.reject(&c.into_owned())).collect();
        if columns.is_empty() {
            DMatrix::zeros(self.rows, 0)
        } else {
            DMatrix::from_columns(&columns)
        }
    }

    /// Squared norm of the projection of `x` on the basis.
    pub(crate) fn explained(&self, x: &DVector<f64>) -> f64 {
        self.vectors.iter().map(|q| q.dot(x).powi(2)).sum()
    }

    /// The given rows of [`Basis::matrix`].
    pub(crate) fn rows(&self, rows: &[usize]) -> DMatrix<f64> {
        DMatrix::from_fn(rows.len(), self.vectors.len(), |i, k| self.vectors[k][rows[i]])
    }

    /// The basis as a matrix, `rows × dim`.
    pub(crate) fn matrix(&self) -> DMatrix<f64> {
        if self.vectors.is_empty() {
            DMatrix::zeros(self.rows, 0)
        } else {
            DMatrix::from_columns(&self.vectors)
        }
    }

    /// Both bases together; columns of `other` that are not new are left out.
    pub(crate) fn with(&self, other: &DMatrix<f64>, min_kept: f64) -> Self {
        let mut both = self.clone();
        for column in other.column_iter() {
            both.push(&column.into_owned(), min_kept);
        }
        both
    }
}

/// Largest cosine of the principal angles between the column spaces of two matrices.
pub(crate) fn largest_cosine(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    if a.ncols() == 0 || b.ncols() == 0 {
        return 0.0;
    }
    (a.transpose() * b).singular_values().max().min(1.0)
}

/// Smallest cosine: near 1 when the smaller space lies inside the larger one.
pub(crate) fn smallest_cosine(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    if a.ncols() == 0 || b.ncols() == 0 {
        return 0.0;
    }
    (a.transpose() * b).singular_values().min().min(1.0)
}
