//! Shapes along a covariate at a glance: the classical F test tells which are worth a hearing.

use nalgebra::{DMatrix, DVector};

use crate::algebra::basis::Basis;
use crate::choice::shape::{Shape, is_constant};
use crate::levels::MIN_SHAPE_KEPT;
use crate::noise::linear::Linear;
use crate::tests::f_test::{Significance, f_test_of};

/// Shapes whose columns are taken together: more would not stay in a processor's cache.
const TOGETHER: usize = 16;

/// What shapes are tested beside.
pub(crate) struct Screening<'a> {
    pub(crate) lin: &'a Linear<'a>,
    /// What the system leaves of the data.
    clean: Rest,
    /// The span of the system, one direction a row.
    held: DMatrix<f64>,
    /// What it leaves of the constants that go along with a shape, one direction a row.
    constants: DMatrix<f64>,
    /// What both leave of the data.
    varying: Rest,
}

/// What is left of the data, and its square.
struct Rest {
    residual: DVector<f64>,
    square: f64,
}

impl Rest {
    fn new(residual: DVector<f64>) -> Self {
        Self { square: residual.norm_squared(), residual }
    }
}

impl<'a> Screening<'a> {
    pub(crate) fn new(lin: &'a Linear<'a>, clean: &DVector<f64>) -> Self {
        let ones = vec![1.0; lin.layout.observations.len()];
        let tangent = DMatrix::from_columns(&lin.followed(&ones));
        let beside = lin.basis.reject_columns(&tangent);
        let mut constants = Basis::empty(tangent.nrows());
        for (left, whole) in beside.column_iter().zip(tangent.column_iter()) {
            constants.push(&left.into_owned(), whole.norm(), MIN_SHAPE_KEPT);
        }
        Self {
            lin,
            clean: Rest::new(clean.clone()),
            held: lin.basis.matrix().transpose(),
            constants: constants.matrix().transpose(),
            varying: Rest::new(constants.reject(clean)),
        }
    }

    /// The F test of each shape beside the constants that go along; `None` where nothing is left
    /// to test.
    pub(crate) fn screened(&self, shapes: &[Shape]) -> Vec<Option<Significance>> {
        shapes.chunks(TOGETHER).flat_map(|some| self.together(some)).collect()
    }

    fn together(&self, shapes: &[Shape]) -> Vec<Option<Significance>> {
        let columns = |shape: &Shape| -> Vec<DVector<f64>> {
            let varying = shape.functions.iter().filter(|(name, _)| !is_constant(name));
            varying.flat_map(|(_, values)| self.lin.followed(values)).collect()
        };
        let columns: Vec<_> = shapes.iter().map(columns).collect();
        let tangent = DMatrix::from_columns(&columns.concat());
        let held = &self.held * &tangent;
        let constants = &self.constants * &tangent;
        let mut start = 0;
        let test = |(shape, columns): (&Shape, &Vec<DVector<f64>>)| {
            let along = shape.functions.iter().any(|(name, _)| is_constant(name));
            let (rest, n_constants) =
                if along { (&self.varying, constants.nrows()) } else { (&self.clean, 0) };
            let (first, n) = (start, columns.len());
            start += n;
            let part = |m: &DMatrix<f64>| m.columns(first, n).into_owned();
            let (whole, held, level) = (part(&tangent), part(&held), part(&constants));
            let squares = whole.tr_mul(&whole);
            let mut left = &squares - held.tr_mul(&held);
            if along {
                left -= level.tr_mul(&level);
            }
            let (explained, directions) =
                explained(&left, &squares.diagonal(), &whole.tr_mul(&rest.residual));
            let base_dim = self.held.nrows() + n_constants;
            f_test_of(explained, directions, rest.square, rest.residual.len(), base_dim)
        };
        shapes.iter().zip(&columns).map(test).collect()
    }
}

/// Square of a residual that columns explain, from their products with each other and with it, and
/// how many directions they have; a column of which less than a share of its `whole` square is new
/// beside those before it counts for nothing (Cholesky's factor, row by row).
fn explained(products: &DMatrix<f64>, whole: &DVector<f64>, onto: &DVector<f64>) -> (f64, usize) {
    // Rows of the factor, each with what it takes of the residual.
    let mut kept: Vec<(usize, Vec<f64>, f64)> = Vec::new();
    for column in 0..products.ncols() {
        let mut row: Vec<f64> = Vec::with_capacity(kept.len() + 1);
        for (other, earlier, _) in &kept {
            let known: f64 = earlier.iter().zip(&row).map(|(a, b)| a * b).sum();
            row.push((products[(*other, column)] - known) / earlier[row.len()]);
        }
        let new = products[(column, column)] - row.iter().map(|v| v * v).sum::<f64>();
        // `>` also turns away NaN and the zero column.
        if new > MIN_SHAPE_KEPT * MIN_SHAPE_KEPT * whole[column] {
            let known: f64 = kept.iter().zip(&row).map(|((_, _, took), v)| took * v).sum();
            let length = new.sqrt();
            row.push(length);
            kept.push((column, row, (onto[column] - known) / length));
        }
    }
    (kept.iter().map(|(_, _, took)| took * took).sum(), kept.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Round-off of products of numbers near one.
    const ROUND_OFF: f64 = 1e-12;

    #[test]
    fn what_columns_explain_is_what_their_span_explains() {
        let entry = |i: usize, j: usize| f64::from(u8::try_from((7 * i + 5 * j * j) % 11).unwrap());
        let mut columns = DMatrix::from_fn(9, 4, entry);
        // The third is the sum of the first two.
        let sum = columns.column(0) + columns.column(1);
        columns.set_column(2, &sum);
        let residual = DVector::from_fn(9, |i, _| entry(i, 3) - entry(i, 5));
        let span = Basis::of(&columns, MIN_SHAPE_KEPT);
        let products = columns.tr_mul(&columns);
        let (explained, directions) =
            explained(&products, &products.diagonal(), &columns.tr_mul(&residual));
        assert_eq!(directions, 3);
        let exact = span.explained(&residual);
        assert!((explained - exact).abs() < ROUND_OFF * exact.max(1.0), "{explained} {exact}");
    }
}
