//! Settings of a case of a part, and the names of its tables.

use pose_icp::PoseError;
use serde::Deserialize;
use toml::Spanned;

use crate::Error;
use crate::case::{Finite, Location, LoopSettings, Positive};
use crate::depth::PolishingTool;
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
    pub(super) tool: Option<ToolSettings>,
    #[serde(default)]
    pub(super) noise: NoiseSettings,
    #[serde(default)]
    pub(super) plan: PlanSettings,
    #[serde(default, rename = "conformity")]
    pub(super) _conformity: serde::de::IgnoredAny,
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
    /// Where gamma is not held.
    pub(super) gamma_deg: Option<Spanned<Finite>>,
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

/// A polishing tool whose film the part presses in.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ToolSettings {
    pub(super) film_mm: Positive,
    pub(super) depth_mm: Option<Positive>,
    pub(super) tolerance_mm: Option<Positive>,
    pub(super) std_film_mm: Option<Positive>,
    pub(super) std_tip_mm: Option<Positive>,
    pub(super) std_axis_mm: Option<Positive>,
    pub(super) std_form_mm: Option<Positive>,
    pub(super) removal_exponent: Option<Positive>,
}

impl ToolSettings {
    pub(super) fn tool(&self) -> PolishingTool {
        let or_none = |value: &Option<Positive>| value.as_ref().map_or(0.0, |Positive(v)| *v);
        let given = |value: &Option<Positive>| value.as_ref().map(|Positive(v)| *v);
        PolishingTool {
            film_mm: self.film_mm.0,
            depth_mm: given(&self.depth_mm),
            tolerance_mm: given(&self.tolerance_mm).unwrap_or(TOLERANCE_MM),
            std_film_mm: or_none(&self.std_film_mm),
            std_tip_mm: or_none(&self.std_tip_mm),
            std_axis_mm: or_none(&self.std_axis_mm),
            std_form_mm: or_none(&self.std_form_mm),
            removal_exponent: given(&self.removal_exponent),
        }
    }
}

/// What document \[D\] asks of the immersion of its ribbon, ± mm.
const TOLERANCE_MM: f64 = 0.010;

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
