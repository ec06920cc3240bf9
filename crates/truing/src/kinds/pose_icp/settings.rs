//! Settings of a case of a part, and the names of its tables.

use pose_icp::PoseError;
use serde::Deserialize;
use toml::Spanned;

use crate::Error;
use crate::case::{Finite, Location, LoopSettings, Positive};
use crate::kinds::surface::SurfaceSettings;
use crate::kinds::touching::PlanSettings;

pub(super) const POINTS: &str = "points.csv";
pub(super) const EDGE: &str = "edge.csv";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Settings {
    #[serde(rename = "kind")]
    pub(super) _kind: serde::de::IgnoredAny,
    pub(super) surface: SurfaceSettings,
    #[serde(default)]
    pub(super) pose: PoseSettings,
    #[serde(default)]
    pub(super) probe: ProbeSettings,
    #[serde(default)]
    pub(super) machine: MachineSettings,
    #[serde(default)]
    pub(super) noise: NoiseSettings,
    #[serde(default)]
    pub(super) plan: PlanSettings,
    #[serde(default, rename = "loop")]
    pub(super) closure: LoopSettings,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PoseSettings {
    pub(super) gamma_deg: Option<Finite>,
    pub(super) initial: Option<Initial>,
    pub(super) held: Option<Spanned<Vec<ParameterName>>>,
    pub(super) known: Option<Spanned<Vec<ParameterName>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Initial {
    pub(super) x_mm: Finite,
    pub(super) y_mm: Finite,
    pub(super) z_mm: Finite,
    #[serde(default = "zero")]
    pub(super) alpha_deg: Finite,
    #[serde(default = "zero")]
    pub(super) beta_deg: Finite,
}

pub(super) fn zero() -> Finite {
    Finite(0.0)
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum ParameterName {
    X,
    Y,
    Z,
    Alpha,
    Beta,
    Gamma,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ProbeSettings {
    pub(super) tip_radius_mm: Option<Finite>,
    #[serde(default)]
    pub(super) side: SideName,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MachineSettings {
    /// False for a laser tracker.
    pub(super) axes: Option<bool>,
}

#[derive(Clone, Copy, Default, Deserialize)]
pub(super) enum SideName {
    #[default]
    #[serde(rename = "+z")]
    Above,
    #[serde(rename = "-z")]
    Below,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NoiseSettings {
    pub(super) point_mm: Option<Positive>,
    pub(super) edge_mm: Option<Positive>,
}

pub(super) fn error(at: Location, source: PoseError) -> Error {
    Error::PoseIcp { at: Box::new(at), source: Box::new(source) }
}
