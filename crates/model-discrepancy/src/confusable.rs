//! How alike the candidates look in this design.

use nalgebra::DMatrix;

use crate::basis::{Basis, largest_cosine};
use crate::candidate::{Sight, catalogue};
use crate::judge::Setting;
use crate::linear::{Linear, NEW_DIRECTION};
use crate::significance::Reach;
use crate::system::{Estimate, System};

/// Largest cosine between projected tangents of the effects that the design sees.
///
/// Candidates that live in one group (there is one per group) are left out.
pub(crate) fn confusability(
    setting: &Setting<'_>,
    base: &Estimate,
    keep: &[bool],
) -> (DMatrix<f64>, Vec<String>) {
    let declared = System::declared(setting.model);
    let lin = Linear::of(&declared, base, keep, setting.silent);
    let candidates: Vec<_> = catalogue(&declared, base, &lin)
        .into_iter()
        .filter_map(|(_, sight)| match sight {
            Sight::Seen(c) if c.reach == Reach::Many => Some(c),
            _ => None,
        })
        .collect();
    let spans: Vec<_> =
        candidates.iter().map(|c| Basis::of(&c.beside, NEW_DIRECTION).matrix()).collect();
    let n = spans.len();
    let matrix = DMatrix::from_fn(n, n, |i, j| largest_cosine(&spans[i], &spans[j]));
    (matrix, candidates.iter().map(|c| c.label()).collect())
}
