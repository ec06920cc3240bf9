//! Settings of a case of a probe, and the names of its tables.

use probe_comp::ProbeError;
use serde::Deserialize;
use toml::Spanned;

use crate::Error;
use crate::case::{Finite, Location, LoopSettings, Positive};
use crate::kinds::surface::SurfaceSettings;
use crate::kinds::touching::PlanSettings;

pub(super) const TOUCHES: &str = "touches.csv";
pub(super) const MICRO: &str = "micro.csv";
/// Touches of the artefact.
pub(super) const QUALIFICATION: &str = "qualification.csv";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Settings {
    #[serde(rename = "kind")]
    pub(super) _kind: serde::de::IgnoredAny,
    pub(super) surface: SurfaceSettings,
    pub(super) probe: ProbeSettings,
    pub(super) qualification: Option<QualificationSettings>,
    #[serde(default)]
    pub(super) model: ModelSettings,
    #[serde(default)]
    pub(super) noise: NoiseSettings,
    #[serde(default)]
    pub(super) plan: PlanSettings,
    #[serde(default, rename = "conformity")]
    pub(super) _conformity: serde::de::IgnoredAny,
    #[serde(default, rename = "loop")]
    pub(super) closure: LoopSettings,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ProbeSettings {
    pub(super) tip_radius_mm: Spanned<Finite>,
    pub(super) side: Option<SideName>,
    pub(super) stylus: Option<Spanned<[Finite; 3]>>,
}

#[derive(Clone, Copy, Deserialize)]
pub(super) enum SideName {
    #[serde(rename = "+z")]
    Above,
    #[serde(rename = "-z")]
    Below,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ModelSettings {
    #[serde(default)]
    pub(super) normal: NormalName,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum NormalName {
    #[default]
    Nominal,
    Approach,
    MicroPlane,
    Quadric,
    SurfaceFit,
    Profile,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NoiseSettings {
    pub(super) point_mm: Option<Positive>,
}

pub(super) fn error(at: Location, source: ProbeError) -> Error {
    Error::ProbeComp { at: Box::new(at), source: Box::new(source) }
}

/// `[qualification]`: a calibrated artefact that the same probe touched.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct QualificationSettings {
    pub(super) shape: ArtefactName,
    pub(super) radius_mm: Positive,
    pub(super) axis: Option<Spanned<[Finite; 3]>>,
    pub(super) lobes: Option<Vec<u32>>,
    pub(super) bending: Option<bool>,
}

#[derive(Clone, Copy, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
pub(super) enum ArtefactName {
    Sphere,
    Ring,
}
