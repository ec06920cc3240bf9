use nalgebra::Point3;

use crate::{AxisModel, ErrorOrder, Mount, RotaryAxis, Station, Step};

/// Points that trackers measured on a rotary axis, each in the frame of its station.
///
/// Records refer to each other by index; names serve messages. One station is enough; where it
/// stood and how it was turned is unknown.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TargetSurvey {
    /// The nominal axis.
    pub axis: RotaryAxis,
    /// Trackers; their nominal places are not used.
    pub stations: Vec<Station>,
    /// Reflectors on the axis; the fit of all to their nominal places is the machine frame.
    pub mounts: Vec<Mount>,
    /// Stops of the axis, in the order measured; the errors are relative to the first one's angle.
    pub steps: Vec<Step>,
    /// Readings in the order measured; what was not seen has no record.
    pub targets: Vec<Target>,
}

impl TargetSurvey {
    /// Its first readings, and what these are of.
    pub(super) fn first(&self, n_readings: usize) -> Self {
        let mut first = self.clone();
        first.targets.truncate(n_readings);
        let targets = &first.targets;
        let n_of =
            |index: fn(&Target) -> usize| targets.iter().map(|t| index(t) + 1).max().unwrap_or(0);
        first.stations.truncate(n_of(|t| t.station));
        first.mounts.truncate(n_of(|t| t.mount));
        first.steps.truncate(n_of(|t| t.step));
        first
    }
}

/// One reading.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Target {
    /// Index into [`TargetSurvey::stations`].
    pub station: usize,
    /// Index into [`TargetSurvey::mounts`].
    pub mount: usize,
    /// Index into [`TargetSurvey::steps`].
    pub step: usize,
    /// Centre of the reflector in the frame of the station, whose origin is the tracker.
    pub at_mm: Point3<f64>,
}

/// Standard uncertainty of one reading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum TargetNoise {
    /// The same in all directions, estimated from the residual.
    #[default]
    Estimated,
    /// The same in all directions.
    Point {
        /// Of each coordinate.
        point_mm: f64,
    },
    /// Along the beam and across it.
    Polar {
        /// Of the distance.
        range_mm: f64,
        /// Of either angle; times the distance it is that across the beam.
        angle_rad: f64,
    },
}

/// How to calibrate from points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TargetOptions {
    /// What the axis is taken for.
    pub axis: AxisModel,
    /// Frame in which the errors are given.
    pub order: ErrorOrder,
    /// Standard uncertainties.
    pub noise: TargetNoise,
}
