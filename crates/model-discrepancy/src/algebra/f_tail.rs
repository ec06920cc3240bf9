//! The F distribution.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// Upper tail of the F distribution; 1 where the statistic is undefined.
pub(crate) fn f_tail(f: f64, dof1: f64, dof2: f64) -> f64 {
    if f.is_nan() || dof2 <= 0.0 {
        return 1.0;
    }
    FisherSnedecor::new(dof1, dof2).map_or(1.0, |d| d.sf(f.max(0.0)))
}
