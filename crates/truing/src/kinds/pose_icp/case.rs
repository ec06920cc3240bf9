//! A case of this kind, as read.

use pose_icp::{PoseOptions, PoseStart};

use super::surface::Surface;
use super::tables::Points;
use crate::case::Location;
use crate::depth::PolishingTool;
use crate::kinds::touching::PlanSettings;

/// A `pose-icp` case as read.
#[derive(Debug)]
pub(super) struct PoseCase {
    pub(super) surface: Surface,
    pub(super) points: Points,
    pub(super) start: PoseStart,
    pub(super) options: PoseOptions,
    /// Declared standard uncertainty of a point.
    pub(super) sigma_mm: Option<f64>,
    /// Whether γ is estimated where the points show it.
    pub(super) ask_gamma: bool,
    /// What the machine can do.
    pub(super) plan: PlanSettings,
    /// The tool that polishes it.
    pub(super) tool: Option<PolishingTool>,
    /// Where that is declared.
    pub(super) document: Location,
}
