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
/// `explained` and `left` are sums of squares in one unit, `dof` the degrees of freedom of what is left.
#[must_use]
pub fn chance_to_explain(explained: f64, directions: usize, left: f64, dof: usize) -> f64 {
    if directions == 0 {
        return 1.0;
    }
    let f = explained / count(directions) / (left.max(0.0) / count(dof));
    f_tail(f, count(directions), count(dof))
}
