//! Settings of a case of two frames, and the names of its tables and columns.

use serde::Deserialize;

use crate::case::{LoopSettings, Positive};
use crate::kinds::touching::Range;
use crate::kinds::undeclared;

pub(super) const POSES: &str = "poses.csv";
pub(super) const DISTANCES: &str = "distances.csv";
pub(super) const COORDINATES: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
pub(super) const PAIRS: &str = "pairs.csv";
pub(super) const FROM: [&str; 3] = ["from_x_mm", "from_y_mm", "from_z_mm"];
pub(super) const TO: [&str; 3] = ["to_x_mm", "to_y_mm", "to_z_mm"];
pub(super) const SIGMA: [&str; 3] = ["sigma_x_mm", "sigma_y_mm", "sigma_z_mm"];
pub(super) const KNOWN: &[&str] = &[
    "point", FROM[0], FROM[1], FROM[2], TO[0], TO[1], TO[2], "sigma_mm", SIGMA[0], SIGMA[1],
    SIGMA[2], "use", "body",
];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Settings {
    #[serde(rename = "kind")]
    pub(super) _kind: serde::de::IgnoredAny,
    #[serde(default)]
    pub(super) model: ModelSettings,
    #[serde(default)]
    pub(super) noise: NoiseSettings,
    #[serde(default)]
    pub(super) plan: FramePlanSettings,
    #[serde(default, rename = "conformity")]
    pub(super) _conformity: serde::de::IgnoredAny,
    #[serde(default, rename = "loop")]
    pub(super) closure: LoopSettings,
}

#[derive(Default, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub(super) struct ModelSettings {
    #[serde(default)]
    pub(super) transform: TransformName,
    #[serde(default)]
    pub(super) handedness: HandednessName,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NoiseSettings {
    pub(super) point_mm: Option<Positive>,
}

#[derive(Clone, Copy, Default, Deserialize, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub(super) enum TransformName {
    None,
    Translation,
    #[default]
    Rigid,
    Similarity,
    Affine,
}

#[derive(Clone, Copy, Default, Deserialize, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub(super) enum HandednessName {
    #[default]
    Proper,
    Improper,
}

/// `[plan]`: where points can be measured, in the first frame.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FramePlanSettings {
    pub(super) x_mm: Option<Range>,
    pub(super) y_mm: Option<Range>,
    pub(super) z_mm: Option<Range>,
    pub(super) spacing_mm: Option<Positive>,
    pub(super) minutes_per_measurement: Option<Positive>,
}

impl FramePlanSettings {
    /// Keys that are not declared and would offer more, in so many dimensions.
    pub(super) fn undeclared(&self, dimensions: usize) -> Vec<&'static str> {
        undeclared(&[
            ("x_mm", self.x_mm.is_some()),
            ("y_mm", self.y_mm.is_some()),
            ("z_mm", self.z_mm.is_some() || dimensions < 3),
        ])
    }
}
