//! How alike the candidates look in this design.

use nalgebra::DMatrix;

use crate::algebra::basis::{Basis, NEW_DIRECTION};
use crate::algebra::product::gram;
use crate::algebra::system::{Estimate, System};
use crate::choice::candidate::{Estimability, catalogue};
use crate::choice::context::Context;
use crate::noise::linear::Linear;
use crate::tests::significance::Reach;

/// Largest cosine between projected tangents of the effects that the design sees.
///
/// Candidates that live in one group (there is one per group) are left out.
pub(crate) fn confusability(
    context: &Context<'_>,
    base: &Estimate,
    lin: &Linear<'_>,
) -> (DMatrix<f64>, Vec<String>) {
    let declared = System::declared(context.model);
    let candidates: Vec<_> = catalogue(&declared, base, lin)
        .into_iter()
        .filter_map(|(_, sight)| match sight {
            Estimability::Estimable(c) if c.reach == Reach::Many => Some(c),
            _ => None,
        })
        .collect();
    let spans: Vec<_> =
        candidates.iter().map(|c| Basis::of(&c.beside, NEW_DIRECTION).matrix()).collect();
    let columns: Vec<_> = spans.iter().flat_map(DMatrix::column_iter).collect();
    let n = spans.len();
    let mut matrix = DMatrix::identity(n, n);
    if !columns.is_empty() {
        let all = DMatrix::from_columns(&columns);
        let cosines = gram(&all);
        let mut first = 0;
        let mut place = |span: &DMatrix<f64>| {
            first += span.ncols();
            (first - span.ncols(), span.ncols())
        };
        let places: Vec<(usize, usize)> = spans.iter().map(&mut place).collect();
        for (i, &(row, rows)) in places.iter().enumerate() {
            for (j, &(column, columns)) in places.iter().enumerate().skip(i + 1) {
                let block = cosines.view((row, column), (rows, columns)).into_owned();
                let largest = block.singular_values().max().min(1.0);
                (matrix[(i, j)], matrix[(j, i)]) = (largest, largest);
            }
        }
    }
    (matrix, candidates.iter().map(|c| c.label()).collect())
}
