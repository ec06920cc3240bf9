//! Reported components of observations.

use crate::{Layout, Row};

/// What a component that follows `values` adds to the residual of a row: what is predicted is taken
/// off.
pub(crate) fn added(row: &Row, component: usize, values: &[f64]) -> f64 {
    if row.reported && row.component == component { -values[row.observation] } else { 0.0 }
}

/// Components of an observation of which any is reported.
pub(crate) fn reported_components(layout: &Layout) -> usize {
    layout.rows.iter().filter(|r| r.reported).map(|r| r.component + 1).max().unwrap_or(0)
}
