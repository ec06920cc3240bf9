//! What a head can still be made to do, as `case.toml` says it.

use serde::Deserialize;

use crate::case::{Finite, Positive};
use crate::kinds::lean::Lean;

/// `[plan]` of a head: what it can be made to do on a plate.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HeadPlanSettings {
    pub(super) leans_deg: Option<Vec<Lean>>,
    pub(super) loads_n: Option<Vec<Finite>>,
    pub(super) axial_mm_per_s: Option<Vec<Finite>>,
    pub(super) seconds: Option<Positive>,
    pub(super) minutes_per_measurement: Option<Positive>,
}
