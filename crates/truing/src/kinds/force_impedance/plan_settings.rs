//! What a head can still be made to do, as `case.toml` says it.

use serde::Deserialize;
use serde::de::{Deserializer, Error};

use crate::case::{Finite, Positive};
use crate::kinds::lean::Lean;
use crate::kinds::undeclared;

/// `[plan]` of a head: what it can be made to do on a plate.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HeadPlanSettings {
    pub(super) leans_deg: Option<Vec<Lean>>,
    pub(super) loads_n: Option<Vec<Load>>,
    pub(super) axial_mm_per_s: Option<Vec<Finite>>,
    pub(super) seconds: Option<Positive>,
    pub(super) minutes_per_measurement: Option<Positive>,
}

impl HeadPlanSettings {
    /// Keys that are not declared and would offer more.
    pub(super) fn undeclared(&self) -> Vec<&'static str> {
        undeclared(&[
            ("leans_deg", self.leans_deg.is_some()),
            ("loads_n", self.loads_n.is_some()),
            ("axial_mm_per_s", self.axial_mm_per_s.is_some()),
        ])
    }
}

/// A normal force, nought where the head hangs free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Load(pub(super) f64);

impl<'de> Deserialize<'de> for Load {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Finite(load_n) = Finite::deserialize(deserializer)?;
        if load_n >= 0.0 {
            return Ok(Self(load_n));
        }
        Err(D::Error::custom(format_args!("expected a force from 0 on, found {load_n}")))
    }
}
