use std::fmt;

/// Which of the two geometries is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// What is moved.
    Source,
    /// What it is moved onto.
    Target,
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Source => "source",
            Self::Target => "target",
        })
    }
}

/// Why two clouds, or a cloud and a mesh, could not be registered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RegisterError {
    /// There is nothing to work on.
    #[error("the {side} holds no points")]
    Empty {
        /// Which one.
        side: Side,
    },
    /// A coordinate is NaN, infinite, or larger than any machine.
    #[error(
        "point {index} of the {side} has a coordinate of {value} mm, which is not a finite number \
         up to {limit:.0e} mm"
    )]
    InvalidPoint {
        /// Which cloud.
        side: Side,
        /// Position in the cloud, from 0.
        index: usize,
        /// The coordinate.
        value: f64,
        /// Largest magnitude that is accepted.
        limit: f64,
    },
    /// There are normals, but not one for each point.
    #[error("the {side} has {points} points and {normals} normals: give one for each or none")]
    NormalCount {
        /// Which cloud.
        side: Side,
        /// Points given.
        points: usize,
        /// Normals given.
        normals: usize,
    },
    /// A normal is not of length 1.
    #[error("normal {index} of the {side} has length {length}, not 1")]
    InvalidNormal {
        /// Which cloud.
        side: Side,
        /// Position in the cloud, from 0.
        index: usize,
        /// Its length.
        length: f64,
    },
}
