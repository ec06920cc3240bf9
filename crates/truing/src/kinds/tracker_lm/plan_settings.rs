//! What a tracer and its axis can still measure, as `case.toml` says it.

use serde::Deserialize;

use crate::case::{Finite, Positive};
use crate::kinds::touching::Range;
use crate::kinds::undeclared;

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
    /// Times that every run is offered; once where it is not declared.
    pub(super) cycles: Option<u8>,
    pub(super) minutes_per_measurement: Option<Positive>,
}

impl TracerPlanSettings {
    /// Keys that are not declared and would offer more; of an axis, or of a head with two.
    pub(super) fn undeclared(&self, has_second: bool) -> Vec<&'static str> {
        undeclared(&[
            ("angles_deg", self.angles_deg.is_some()),
            ("second_angles_deg", self.second_angles_deg.is_some() || !has_second),
            // Where it can stand.
            ("x_mm", self.x_mm.is_some()),
            ("y_mm", self.y_mm.is_some()),
            ("z_mm", self.z_mm.is_some()),
            ("mounts_mm", self.mounts_mm.is_some()),
            ("cycles", self.cycles.is_some()),
        ])
    }
}
