use nalgebra::{Unit, Vector3};

/// A calibrated artefact; where it stands is found from the touches.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Reference {
    /// A sphere, touched from outside.
    Sphere {
        /// Its radius.
        radius_mm: f64,
    },
    /// A ring, touched from inside at right angles to its axis.
    Ring {
        /// Its radius.
        radius_mm: f64,
        /// Its axis.
        axis: Unit<Vector3<f64>>,
    },
}

/// What is asked of a probe beside the radius of its ball.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ProbeTerms {
    /// Axis of the stylus.
    pub stylus: Unit<Vector3<f64>>,
    /// Harmonics of the trigger's travel by azimuth about the stylus, in proportion to the sideways
    /// part of the approach: 3 for a probe on three seats. From 2 on; the first is the place of
    /// the artefact.
    pub lobes: Vec<u32>,
    /// Whether the stylus gives way sideways; a ring does not tell that from the ball's radius.
    pub bending: bool,
}

impl Default for ProbeTerms {
    /// A vertical stylus, three lobes, and bending.
    fn default() -> Self {
        Self { stylus: Vector3::z_axis(), lobes: vec![3], bending: true }
    }
}

impl Reference {
    pub(crate) fn radius_mm(&self) -> f64 {
        match self {
            Self::Sphere { radius_mm } | Self::Ring { radius_mm, .. } => *radius_mm,
        }
    }

    /// +1 where the ball is outside, −1 inside.
    pub(crate) fn side(&self) -> f64 {
        match self {
            Self::Sphere { .. } => 1.0,
            Self::Ring { .. } => -1.0,
        }
    }

    /// The part of an arm from the artefact's place that counts.
    pub(crate) fn across(&self, arm: Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Sphere { .. } => arm,
            Self::Ring { axis, .. } => arm - axis.into_inner() * axis.dot(&arm),
        }
    }
}
