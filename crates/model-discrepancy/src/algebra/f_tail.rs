//! The F distribution.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::count::count;

/// Upper tail of the F distribution; 1 where the statistic is undefined.
pub(crate) fn f_tail(f: f64, dof1: f64, dof2: f64) -> f64 {
    if f.is_nan() || dof2 <= 0.0 {
        return 1.0;
    }
    FisherSnedecor::new(dof1, dof2).map_or(1.0, |d| d.sf(f.max(0.0)))
}

/// Chance that so many directions explain as much of white noise (F test): 1 where there is none of them,
/// or nothing to judge by.
///
/// `ratio` is what they explain over what is left, both as sums of squares, and `dof` the degrees of freedom
/// of what is left.
#[must_use]
pub fn chance_to_explain(ratio: f64, directions: usize, dof: usize) -> f64 {
    if directions == 0 {
        return 1.0;
    }
    f_tail(ratio * count(dof) / count(directions), count(directions), count(dof))
}
