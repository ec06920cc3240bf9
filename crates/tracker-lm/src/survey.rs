//! What was measured: plain data, one record per measurement.

use nalgebra::Point3;

use crate::RotaryAxis;

/// Displacements of a laser tracer at several stations, to reflectors on a rotary axis.
///
/// Records refer to each other by index; names serve messages.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Survey {
    /// The nominal axis.
    pub axis: RotaryAxis,
    /// The other axis of a head with two, which rides on [`Self::axis`] and carries the reflectors.
    #[cfg_attr(feature = "serde", serde(default))]
    pub second: Option<SecondAxis>,
    /// Where the tracer stood.
    pub stations: Vec<Station>,
    /// Reflectors on the axis.
    pub mounts: Vec<Mount>,
    /// Stops of the axis, in the order measured; the errors are relative to the first one's angle.
    pub steps: Vec<Step>,
    /// Readings; what was not seen has no record.
    pub ranges: Vec<Range>,
}

impl Survey {
    /// Its first ranges, and what these are of.
    pub(crate) fn first(&self, n_ranges: usize) -> Self {
        let mut first = self.clone();
        first.ranges.truncate(n_ranges);
        let ranges = &first.ranges;
        let n_of =
            |index: fn(&Range) -> usize| ranges.iter().map(|r| index(r) + 1).max().unwrap_or(0);
        first.stations.truncate(n_of(|r| r.station));
        first.mounts.truncate(n_of(|r| r.mount));
        let n_steps = n_of(|r| r.step);
        first.steps.truncate(n_steps);
        if let Some(second) = &mut first.second {
            second.angles_rad.truncate(n_steps);
        }
        first
    }
}

/// The rotary axis of a head that another one carries.
///
/// Each axis turns while the other one stands; the pose in which both stand is measured too, and the
/// errors of both are relative to it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SecondAxis {
    /// The nominal axis where the first one stands, machine frame.
    pub axis: RotaryAxis,
    /// Its commanded angle at every step.
    pub angles_rad: Vec<f64>,
}

/// A place of the tracer.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Station {
    /// Name.
    pub name: String,
    /// Nominal position, machine frame.
    pub nominal_mm: Point3<f64>,
}

/// A place of a reflector.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mount {
    /// Name.
    pub name: String,
    /// Nominal centre in the frame that turns with the axis, of two with the second one, which at
    /// angle 0 is parallel to the machine's with its origin in that of the axis.
    pub nominal_mm: Point3<f64>,
}

/// A stop of the axis.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Step {
    /// Name.
    pub name: String,
    /// Commanded angle, of two axes that of the first.
    pub angle_rad: f64,
    /// Which way the axis came.
    pub approach: Option<Approach>,
}

/// Which way an axis came to its stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Approach {
    /// Through rising angles.
    Positive,
    /// Through falling angles.
    Negative,
}

/// One reading: `|P − S| = displacement + dead path`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Range {
    /// Index into [`Survey::stations`].
    pub station: usize,
    /// Index into [`Survey::mounts`].
    pub mount: usize,
    /// Index into [`Survey::steps`].
    pub step: usize,
    /// Change of the path since the tracer locked on.
    pub displacement_mm: f64,
}
