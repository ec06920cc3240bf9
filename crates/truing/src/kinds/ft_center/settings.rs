//! Settings of a case of a sensor, and the names of its tables.

use ft_center::{FtCenterError, Handedness};
use serde::Deserialize;
use toml::Spanned;

use super::plan_settings::SensorPlanSettings;
use crate::Error;
use crate::case::{Conformance, Finite, Location, LoopSettings, Positive};

pub(super) const PRESSES: &str = "presses.csv";
pub(super) const WRENCH: &str = "wrench.csv";
pub(super) const DISPLACEMENTS: &str = "displacements.csv";
pub(super) const GRAVITY: &str = "gravity.csv";

/// Settings of the kind; which of them are needed depends on the tables.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Settings {
    #[serde(rename = "kind")]
    pub(super) _kind: serde::de::IgnoredAny,
    #[serde(default)]
    pub(super) contact: ContactSettings,
    #[serde(default)]
    pub(super) model: ModelSettings,
    #[serde(default)]
    pub(super) plan: SensorPlanSettings,
    #[serde(default)]
    pub(super) frame: FrameSettings,
    #[serde(default)]
    pub(super) tolerance: ToleranceSettings,
    #[serde(default)]
    pub(super) noise: NoiseSettings,
    #[serde(default, rename = "conformity")]
    pub(super) _conformity: serde::de::IgnoredAny,
    #[serde(default, rename = "loop")]
    pub(super) closure: LoopSettings,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ContactSettings {
    pub(super) z0_mm: Option<Finite>,
    pub(super) min_fz_n: Option<Positive>,
    pub(super) spin_hz: Option<Positive>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ModelSettings {
    pub(super) handedness: Option<HandednessName>,
    pub(super) gravity: Option<[Finite; 3]>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NoiseSettings {
    pub(super) force_n: Option<Positive>,
    pub(super) moment_nmm: Option<Positive>,
    pub(super) displacement_mm: Option<Positive>,
}

/// `[frame]`: where the sensor is, found before.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FrameSettings {
    pub(super) from: Option<Spanned<String>>,
}

/// `[tolerance]`: what the head is held against.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ToleranceSettings {
    pub(super) repeatability_mm: Option<Positive>,
    pub(super) conformance: Option<Conformance>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum HandednessName {
    Same,
    Opposed,
}

impl From<HandednessName> for Handedness {
    fn from(name: HandednessName) -> Self {
        match name {
            HandednessName::Same => Self::Same,
            HandednessName::Opposed => Self::Opposed,
        }
    }
}

/// Settings that have no meaning for the tables given, as warnings.
pub(super) fn unused(settings: &[(&str, bool)], table: &str) -> Vec<String> {
    (settings.iter().filter(|(_, is_set)| *is_set))
        .map(|(key, _)| format!("`{key}` is not used with {table}"))
        .collect()
}

pub(super) fn error(at: Location, source: FtCenterError) -> Error {
    Error::FtCenter { at: Box::new(at), source: Box::new(source) }
}
