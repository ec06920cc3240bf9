//! How alike the candidates look in this design.

use nalgebra::DMatrix;

use crate::algebra::basis::NEW_DIRECTION;
use crate::algebra::basis::{Basis, largest_cosine};
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
    keep: &[bool],
) -> (DMatrix<f64>, Vec<String>) {
    let declared = System::declared(context.model);
    let lin = Linear::of(&declared, base, keep, context.silent);
    let candidates: Vec<_> = catalogue(&declared, base, &lin)
        .into_iter()
        .filter_map(|(_, sight)| match sight {
            Estimability::Estimable(c) if c.reach == Reach::Many => Some(c),
            _ => None,
        })
        .collect();
    let spans: Vec<_> =
        candidates.iter().map(|c| Basis::of(&c.beside, NEW_DIRECTION).matrix()).collect();
    let n = spans.len();
    let matrix = DMatrix::from_fn(n, n, |i, j| largest_cosine(&spans[i], &spans[j]));
    (matrix, candidates.iter().map(|c| c.label()).collect())
}
