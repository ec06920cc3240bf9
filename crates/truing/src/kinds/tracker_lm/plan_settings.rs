//! What a tracer and its axis can still measure, as `case.toml` says it.

use serde::Deserialize;

use crate::case::{Finite, Positive};
use crate::kinds::touching::Range;

/// `[plan]` of a tracer: where it can stand, what it can look at, how the axis can turn.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TracerPlanSettings {
    pub(super) x_mm: Option<Range>,
    pub(super) y_mm: Option<Range>,
    pub(super) z_mm: Option<Range>,
    pub(super) spacing_mm: Option<Positive>,
    pub(super) angles_deg: Option<Vec<Finite>>,
    /// Of the second axis of a head.
    pub(super) second_angles_deg: Option<Vec<Finite>>,
    pub(super) mounts_mm: Option<Vec<[Finite; 3]>>,
    pub(super) minutes_per_measurement: Option<Positive>,
}
