//! Settings of a case of a head, and the names of its tables and columns.

use force_impedance::ForceFormula;
use serde::Deserialize;

use super::plan_settings::HeadPlanSettings;
use crate::case::{Finite, LoopSettings, Positive};

pub(super) const LOG: &str = "log.csv";
pub(super) const PATH: &str = "path.csv";
pub(super) const KNOWN: &[&str] = &[
    "time_s",
    "l1_mm",
    "l2_mm",
    "l3_mm",
    "l4_mm",
    "f1_n",
    "f2_n",
    "f3_n",
    "f4_n",
    "nx",
    "ny",
    "nz",
    "reference_n",
    "segment",
];
pub(super) const LENGTHS: [&str; 4] = ["l1_mm", "l2_mm", "l3_mm", "l4_mm"];
pub(super) const CELLS: [&str; 4] = ["f1_n", "f2_n", "f3_n", "f4_n"];

/// Where the legs stand unless the case says otherwise.
pub(super) const LEG_ANGLES_DEG: [f64; 3] = [90.0, 210.0, 330.0];
/// A step in time this many times the usual one is a pause, not a lost sample or two.
pub(super) const PAUSE: f64 = 5.0;
/// Vectors printed with four digits are this close to unit length; others are slips.
pub(super) const LENGTH_TOL: f64 = 1e-3;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Settings {
    #[serde(rename = "kind")]
    pub(super) _kind: serde::de::IgnoredAny,
    #[serde(default)]
    pub(super) head: Option<HeadSettings>,
    #[serde(default)]
    pub(super) impedance: Option<ImpedanceSettings>,
    #[serde(default)]
    pub(super) model: ModelSettings,
    #[serde(default)]
    pub(super) noise: NoiseSettings,
    #[serde(default, rename = "conformity")]
    pub(super) _conformity: serde::de::IgnoredAny,
    #[serde(default)]
    pub(super) plan: HeadPlanSettings,
    #[serde(default, rename = "loop")]
    pub(super) closure: LoopSettings,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HeadSettings {
    pub(super) tip_to_plane_mm: Positive,
    pub(super) plane_to_joint_mm: Positive,
    pub(super) head_radius_mm: Positive,
    pub(super) bracket_radius_mm: Positive,
    pub(super) leg_angles_deg: Option<[Finite; 3]>,
    pub(super) weight_n: Option<Finite>,
    pub(super) center_of_gravity_mm: Option<Finite>,
    pub(super) gravity: Option<[Finite; 3]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ImpedanceSettings {
    pub(super) mass_kg: Positive,
    pub(super) damping_ns_per_mm: Positive,
    pub(super) stiffness_n_per_mm: Option<Finite>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ModelSettings {
    pub(super) force: Option<FormulaName>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum FormulaName {
    FullBalance,
    Published,
}

impl From<FormulaName> for ForceFormula {
    fn from(name: FormulaName) -> Self {
        match name {
            FormulaName::FullBalance => Self::FullBalance,
            FormulaName::Published => Self::Published,
        }
    }
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NoiseSettings {
    pub(super) force_n: Option<Positive>,
}
