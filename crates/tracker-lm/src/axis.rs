//! The rotary axis: where it is, which way it turns, and what its errors are called.

use geometry::so3;
use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};

use crate::TrackerError;

/// Letter of a rotary axis, ISO 841: A turns about x, B about y, C about z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum AxisLetter {
    /// About x.
    A,
    /// About y.
    B,
    /// About z.
    C,
}

impl AxisLetter {
    /// The letter itself.
    #[must_use]
    pub fn letter(self) -> char {
        match self {
            Self::A => 'A',
            Self::B => 'B',
            Self::C => 'C',
        }
    }

    /// Index of the machine axis it turns about.
    pub(crate) fn own(self) -> usize {
        match self {
            Self::A => 0,
            Self::B => 1,
            Self::C => 2,
        }
    }

    /// Indices of the two machine axes across it.
    pub(crate) fn across(self) -> [usize; 2] {
        match self {
            Self::A => [1, 2],
            Self::B => [0, 2],
            Self::C => [0, 1],
        }
    }

    /// Names of the six errors, ISO 230-1: for B `EXB EYB EZB EAB EBB ECB`.
    #[must_use]
    pub fn error_names(self) -> [String; 6] {
        ["X", "Y", "Z", "A", "B", "C"].map(|of| format!("E{of}{}", self.letter()))
    }

    /// Names of the four location errors, ISO 230-1: for B `EX0B EZ0B EA0B EC0B`.
    #[must_use]
    pub fn location_names(self) -> [String; 4] {
        let [first, second] = self.across();
        [
            ["X", "Y", "Z"][first],
            ["X", "Y", "Z"][second],
            ["A", "B", "C"][first],
            ["A", "B", "C"][second],
        ]
        .map(|of| format!("E{of}0{}", self.letter()))
    }
}

/// A rotary axis as the machine's drawing has it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RotaryAxis {
    /// Its letter, which names the errors.
    pub letter: AxisLetter,
    /// A point on it, machine frame; errors of position are those of this point.
    pub origin_mm: Point3<f64>,
    /// Its direction, machine frame; angles count right-handed about it.
    pub direction: Unit<Vector3<f64>>,
}

/// Length of a direction, relative to its largest entry, below which it has none.
const SHORTEST: f64 = 1e-9;

impl RotaryAxis {
    /// The axis through `origin_mm` along `direction`, which need not be of unit length.
    ///
    /// # Errors
    ///
    /// [`TrackerError::InvalidAxis`] where the direction is zero or a number is not finite.
    pub fn new(
        letter: AxisLetter,
        origin_mm: Point3<f64>,
        direction: Vector3<f64>,
    ) -> Result<Self, TrackerError> {
        let finite = origin_mm.iter().chain(direction.iter()).all(|v| v.is_finite());
        let length = direction.norm();
        if !finite || !length.is_finite() || length < SHORTEST {
            return Err(TrackerError::InvalidAxis { direction: direction.into() });
        }
        Ok(Self { letter, origin_mm, direction: Unit::new_unchecked(direction / length) })
    }

    /// `Rot(b)`: the nominal rotation.
    #[must_use]
    pub fn rotation(&self, angle_rad: f64) -> UnitQuaternion<f64> {
        so3::exp(&(self.direction.into_inner() * angle_rad))
    }

    /// Machine frame from the frame that turns with the axis, `Trans(o) Rot(b)`.
    #[must_use]
    pub fn machine_from_table(&self, angle_rad: f64) -> Isometry3<f64> {
        Isometry3::from_parts(Translation3::from(self.origin_mm.coords), self.rotation(angle_rad))
    }
}
