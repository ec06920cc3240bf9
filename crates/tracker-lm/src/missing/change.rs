//! A change for good at a reading, or one reading that is off.

use crate::Survey;

/// A change that begins with a range, in the order measured, and stays; or is of that range alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Change {
    /// Of a dead path, by the station and mount (or station alone) it belongs to.
    DeadPath { station: usize, mount: Option<usize>, range: usize },
    /// Of the place of a reflector.
    Mount { mount: usize, range: usize },
    /// Of one range.
    Reading { range: usize },
}

impl Change {
    /// Whether a range is measured after the change, of what has changed.
    pub(crate) fn touches(&self, survey: &Survey, index: usize) -> bool {
        let r = &survey.ranges[index];
        match *self {
            Self::DeadPath { station, mount, range } => {
                r.station == station && mount.is_none_or(|j| r.mount == j) && index >= range
            }
            Self::Mount { mount, range } => r.mount == mount && index >= range,
            Self::Reading { range } => index == range,
        }
    }
}

/// A change for the catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Offered {
    pub(crate) change: Change,
    /// How many were looked at to find it; one where the run alone offers it.
    pub(crate) searched: usize,
}
