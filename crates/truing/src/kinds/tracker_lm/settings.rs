//! Settings of a case of a tracer, and the names of its tables.

use serde::Deserialize;
use tracker_lm::TrackerError;

use super::plan_settings::TracerPlanSettings;
use crate::Error;
use crate::case::{Finite, Location, LoopSettings, Positive};

pub(super) const STATIONS: &str = "stations.csv";
pub(super) const MOUNTS: &str = "mounts.csv";
pub(super) const RANGES: &str = "ranges.csv";
pub(super) const TARGETS: &str = "targets.csv";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Settings {
    #[serde(rename = "kind")]
    pub(super) _kind: serde::de::IgnoredAny,
    pub(super) axis: AxisSettings,
    /// The other axis of a head, which rides on `axis` and carries the reflectors.
    pub(super) second_axis: Option<SecondAxisSettings>,
    #[serde(default)]
    pub(super) model: ModelSettings,
    #[serde(default)]
    pub(super) noise: NoiseSettings,
    #[serde(default)]
    pub(super) plan: TracerPlanSettings,
    #[serde(default, rename = "conformity")]
    pub(super) _conformity: serde::de::IgnoredAny,
    #[serde(default, rename = "loop")]
    pub(super) closure: LoopSettings,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AxisSettings {
    pub(super) letter: LetterName,
    /// Where the drawing has the axis; absent: it is found.
    pub(super) origin_mm: Option<[Finite; 3]>,
    pub(super) direction: Option<[Finite; 3]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SecondAxisSettings {
    pub(super) letter: LetterName,
    /// Where the drawing has it while the first axis stands.
    pub(super) origin_mm: [Finite; 3],
    pub(super) direction: Option<[Finite; 3]>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ModelSettings {
    #[serde(default)]
    pub(super) formulation: FormulationName,
    #[serde(default)]
    pub(super) dead_path: DeadPathName,
    #[serde(default)]
    pub(super) gauge: GaugeName,
    #[serde(default)]
    pub(super) order: OrderName,
    #[serde(default)]
    pub(super) axis: AxisName,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NoiseSettings {
    pub(super) displacement_mm: Option<Positive>,
    pub(super) rigid_mm: Option<Positive>,
    pub(super) station_mm: Option<Positive>,
    pub(super) range_mm: Option<Positive>,
    pub(super) angle_rad: Option<Positive>,
    pub(super) point_mm: Option<Positive>,
}

#[derive(Clone, Copy, Deserialize, PartialEq)]
pub(super) enum LetterName {
    A,
    B,
    C,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum FormulationName {
    #[default]
    Joint,
    FreePoints,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum AxisName {
    #[default]
    Free,
    Fixed,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum DeadPathName {
    #[default]
    Lock,
    Station,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum GaugeName {
    #[default]
    Stations,
    Minimal,
    Inner,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum OrderName {
    #[default]
    Fixed,
    Rotating,
}

pub(super) fn error(at: Location, source: TrackerError) -> Error {
    Error::TrackerLm { at: Box::new(at), source: Box::new(source) }
}
