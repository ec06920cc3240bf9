//! What a sensor and its machine can still measure, as `case.toml` says it.

use serde::Deserialize;

use crate::case::{Finite, Positive};
use crate::kinds::lean::Lean;
use crate::kinds::positioning::{AxisPlanSettings, Ways};
use crate::kinds::touching::Range;
use crate::kinds::undeclared;

/// `[plan]` of a sensor: where it can be pressed, how hard and how, and how it can be tilted.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SensorPlanSettings {
    pub(super) x_mm: Option<Range>,
    pub(super) y_mm: Option<Range>,
    pub(super) spacing_mm: Option<Positive>,
    pub(super) loads_n: Option<Vec<Positive>>,
    pub(super) leans_deg: Option<Vec<Lean>>,
    pub(super) tilts_deg: Option<Vec<Lean>>,
    pub(super) targets: Option<Vec<Finite>>,
    pub(super) directions: Option<Ways>,
    pub(super) cycles: Option<u8>,
    pub(super) minutes_per_measurement: Option<Positive>,
}

impl SensorPlanSettings {
    /// What of it concerns an axis that is sent to targets.
    pub(super) fn of_axis(&self) -> AxisPlanSettings {
        let Self { targets, directions, cycles, minutes_per_measurement, .. } = self.clone();
        AxisPlanSettings { targets, directions, cycles, minutes_per_measurement }
    }

    /// Keys that are not declared and would offer more presses.
    pub(super) fn undeclared_of_presses(&self) -> Vec<&'static str> {
        undeclared(&[
            ("leans_deg", self.leans_deg.is_some()),
            ("loads_n", self.loads_n.is_some()),
            ("x_mm", self.x_mm.is_some()),
            ("y_mm", self.y_mm.is_some()),
        ])
    }

    pub(super) fn minutes(&self) -> Option<f64> {
        self.minutes_per_measurement.map(|Positive(minutes)| minutes)
    }
}
