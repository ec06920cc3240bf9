//! What an effect moves of a range's geometry.

use nalgebra::{DVector, Vector3, Vector6};

use crate::missing::sights::Sight;
use crate::shift::Shift;

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

impl Moves {
    /// Adds what amplitudes of the effect do to a range.
    pub(crate) fn shift(&self, shift: &mut Shift, amplitudes: &DVector<f64>, range: usize) {
        let share = self.share[range];
        let three = || share * Vector3::from_iterator(amplitudes.iter().copied());
        match self.part {
            Part::Error => {
                shift.error += share * Vector6::from_iterator(amplitudes.iter().copied());
            }
            Part::Station => shift.station_mm += three(),
            Part::Mount => shift.mount_mm += three(),
        }
    }
}
