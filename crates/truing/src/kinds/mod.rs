//! Kinds of cases: one module each, and the table that names them.

mod example;
mod force_impedance;
mod frame_fit;
mod ft_center;
mod lean;
mod offer;
mod orientation;
mod pose_icp;
mod positioning;
mod probe_comp;
mod surface;
mod touching;
mod tracker_lm;

use crate::kind::Kind;

pub use example::{examples, write_example};
pub use force_impedance::{
    ContactForceEstimate, ForceBlock, ForceImpedanceEstimates, ImpedanceEstimate, PathCell,
    PathError, PathForceEstimates,
};
pub use frame_fit::{
    DistanceResidual, FrameFitEstimates, PlaceEstimate, PointResidual, PoseResidual, ScaleEstimate,
    TipEstimates, TransformStd,
};
pub use ft_center::{
    AffineEstimate, CenterEstimate, Conformity, DisplacementEstimates, DisplacementResidual,
    FrameEstimate, FtCenterEstimates, GravityEstimates, LineMiss, MeanWrench,
    RepeatabilityEstimate, WrenchEstimate,
};
pub use positioning::{
    AxisCorrection, AxisFigureEstimate, AxisRunEstimate, AxisTargetEstimate, PositionResidual,
    PositioningEstimates, PositioningFigures,
};
pub use tracker_lm::{
    AxesRelationEstimate, AxisErrorEstimate, AxisEstimate, AxisLocationEstimate, MountEstimate,
    SecondAxisEstimate, StationEstimate, TrackerLmEstimates,
};

pub(crate) use offer::{Beside, Cells, Offer, Offered, PlannedTouch, Reach, undeclared};
pub use pose_icp::{
    HeightCheck, PoseEstimate, PoseIcpEstimates, PoseIntervals, PoseNumbers, TouchResidual,
};
pub(crate) use pose_icp::{plausible_reading, stds};
pub use probe_comp::{
    LobeEstimate, MeasuredNormalEstimate, PlannedContactEstimate, ProbeCompEstimates,
    ProbingCheckEstimate, QualificationEstimate, TouchEstimate,
};

/// Every kind, in the order in which they are listed.
pub(crate) const KINDS: &[Kind] = &[
    frame_fit::KIND,
    ft_center::KIND,
    tracker_lm::KIND,
    pose_icp::KIND,
    probe_comp::KIND,
    force_impedance::KIND,
    positioning::KIND,
];

/// Names of the kinds.
pub fn kinds() -> impl Iterator<Item = (&'static str, &'static str)> {
    KINDS.iter().map(|kind| (kind.name, kind.summary))
}
