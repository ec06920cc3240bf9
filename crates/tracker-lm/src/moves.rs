//! What an effect moves of a range's geometry.

use nalgebra::{DVector, Vector3, Vector6};

use crate::sights::Sight;

/// Part of a range's geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// The six errors of the axis.
    Error,
    /// The station.
    Station,
    /// The reflector, in the frame that turns with the axis.
    Mount,
}

impl Part {
    /// Derivative of the residual by the part's coordinates.
    pub(crate) fn slopes(self, sight: &Sight) -> Vec<f64> {
        match self {
            Self::Error => sight.by_error.iter().copied().collect(),
            Self::Station => (-sight.beam).iter().copied().collect(),
            Self::Mount => sight.by_mount.iter().copied().collect(),
        }
    }
}

/// An effect that moves one part of the geometry.
#[derive(Clone, Debug)]
pub(crate) struct Moves {
    pub(crate) part: Part,
    /// How far one unit moves it, range by range.
    pub(crate) share: Vec<f64>,
}

/// Where accepted effects put the parts of one range, beside where the parameters have them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Shift {
    /// Displacement in mm, rotation in rad.
    pub(crate) error: Vector6<f64>,
    pub(crate) station_mm: Vector3<f64>,
    pub(crate) mount_mm: Vector3<f64>,
}

impl Shift {
    /// Adds what amplitudes of an effect do to a range.
    pub(crate) fn add(&mut self, moves: &Moves, amplitudes: &DVector<f64>, range: usize) {
        let share = moves.share[range];
        let three = || share * Vector3::from_iterator(amplitudes.iter().copied());
        match moves.part {
            Part::Error => self.error += share * Vector6::from_iterator(amplitudes.iter().copied()),
            Part::Station => self.station_mm += three(),
            Part::Mount => self.mount_mm += three(),
        }
    }
}
