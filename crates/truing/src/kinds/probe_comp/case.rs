//! A case of this kind, as read.

use nalgebra::{Unit, Vector3};
use probe_comp::{NormalSource, ProbeUncertainty};

use super::qualification::QualificationEstimate;
use super::surface::PartSurface;
use super::tables::Touches;
use crate::case::Location;
use crate::kinds::touching::PlanSettings;

/// A `probe-comp` case as read.
#[derive(Debug)]
pub(super) struct ProbeCase {
    pub(super) surface: PartSurface,
    pub(super) touches: Touches,
    /// Radius with which the touches are compensated.
    pub(super) tip_radius_mm: f64,
    /// What the probe adds, already taken off the touches.
    pub(super) qualification: Option<QualificationEstimate>,
    /// What that leaves uncertain.
    pub(super) probe: Option<ProbeUncertainty>,
    pub(super) stylus: Unit<Vector3<f64>>,
    pub(super) source: NormalSource,
    /// Declared standard uncertainty of a coordinate.
    pub(super) sigma_mm: Option<f64>,
    /// What the machine can do.
    pub(super) plan: PlanSettings,
    /// Where that is declared.
    pub(super) document: Location,
}
