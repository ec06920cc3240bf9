//! Columns that are new beside those before them, told by their products alone.

use nalgebra::{DMatrix, DVector};

/// The columns that are new, and Cholesky's factor of their products.
#[derive(Clone, Debug)]
pub(crate) struct Independent {
    pub(crate) kept: Vec<usize>,
    /// Lower triangular.
    pub(crate) factor: DMatrix<f64>,
}

impl Independent {
    /// From the products of columns with each other; one of which the square of what is new is not more
    /// than `least` counts for nothing.
    pub(crate) fn of(products: &DMatrix<f64>, least: impl Fn(usize) -> f64) -> Self {
        let m = products.ncols();
        let mut kept: Vec<usize> = Vec::with_capacity(m);
        // Row by row: the factor's columns follow each other.
        let mut rows: Vec<f64> = Vec::new();
        let first = |row: usize| row * (row + 1) / 2;
        for column in 0..m {
            let n = kept.len();
            let start = rows.len();
            for (k, &other) in kept.iter().enumerate() {
                let earlier = &rows[first(k)..first(k) + k];
                let known: f64 = earlier.iter().zip(&rows[start..]).map(|(a, b)| a * b).sum();
                let next = (products[(other, column)] - known) / rows[first(k) + k];
                rows.push(next);
            }
            let new = products[(column, column)] - rows[start..].iter().map(|v| v * v).sum::<f64>();
            // `>` also turns away NaN and the zero column.
            if new > least(column) && new > f64::MIN_POSITIVE {
                rows.push(new.sqrt());
                kept.push(column);
            } else {
                rows.truncate(first(n));
            }
        }
        let entry = |i: usize, j: usize| if j <= i { rows[first(i) + j] } else { 0.0 };
        let factor = DMatrix::from_fn(kept.len(), kept.len(), entry);
        Self { kept, factor }
    }

    /// What the columns' products with something come to along the orthonormal columns that they span.
    pub(crate) fn along(&self, products: &DMatrix<f64>) -> DMatrix<f64> {
        let mut along = products.select_rows(&self.kept);
        self.factor.solve_lower_triangular_mut(&mut along);
        along
    }

    /// The same of one column.
    pub(crate) fn along_one(&self, products: &DVector<f64>) -> DVector<f64> {
        let mut along = products.select_rows(&self.kept);
        self.factor.solve_lower_triangular_mut(&mut along);
        along
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::basis::Basis;

    /// Round-off of products of numbers near ten.
    const ROUND_OFF: f64 = 1e-12;

    #[test]
    fn what_columns_explain_is_what_their_span_explains() {
        let entry = |i: usize, j: usize| f64::from(u8::try_from((7 * i + 5 * j * j) % 11).unwrap());
        let mut columns = DMatrix::from_fn(9, 4, entry);
        // The third is the sum of the first two.
        let sum = columns.column(0) + columns.column(1);
        columns.set_column(2, &sum);
        let residual = DVector::from_fn(9, |i, _| entry(i, 3) - entry(i, 5));
        let products = columns.tr_mul(&columns);
        let new = Independent::of(&products, |c| 0.02_f64.powi(2) * products[(c, c)]);
        assert_eq!(new.kept, [0, 1, 3]);
        let explained = new.along_one(&columns.tr_mul(&residual)).norm_squared();
        let exact = Basis::of(&columns, 0.02).explained(&residual);
        assert!((explained - exact).abs() < ROUND_OFF * exact.max(1.0), "{explained} {exact}");
    }
}
