use std::fmt;

use super::observability::WeakDirection;
use super::registration::Registration;

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
        "point {} of the {side} has a coordinate of {value} mm, which is not a finite number \
         up to {limit:.0e} mm",
        index + 1
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
    #[error("normal {} of the {side} has length {length}, not 1", index + 1)]
    InvalidNormal {
        /// Which cloud.
        side: Side,
        /// Position in the cloud, from 0.
        index: usize,
        /// Its length.
        length: f64,
    },
    /// More points than can be numbered.
    #[error("the {side} has {got} points, more than {limit}: thin it out first")]
    TooManyPoints {
        /// Which cloud.
        side: Side,
        /// Points given.
        got: usize,
        /// Most that are accepted.
        limit: usize,
    },
    /// Fewer points than unknowns.
    #[error(
        "{got} points of the source cannot determine {unknowns} unknowns: measure more, or hold some"
    )]
    TooFewPoints {
        /// Points given.
        got: usize,
        /// Degrees of freedom that are not held.
        unknowns: usize,
    },
    /// The objective needs normals that are not there.
    #[error("this objective needs normals of the {side}: estimate them, or use point-to-point")]
    MissingNormals {
        /// Which cloud.
        side: Side,
    },
    /// The neighbours of a point lie on a line.
    #[error(
        "the {neighbours} points nearest to point {} of the {side} lie on a line, so that it \
         has no normal: take more neighbours, or thin the points out",
        index + 1
    )]
    NoPlane {
        /// Which cloud.
        side: Side,
        /// Position in the cloud, from 0.
        index: usize,
        /// Neighbours looked at.
        neighbours: usize,
    },
    /// A face names a vertex that is not there.
    #[error("face {face} of the {side} names vertex {vertex}, but there are {vertices}, from 0")]
    NoSuchVertex {
        /// Which mesh.
        side: Side,
        /// Position of the face, from 0.
        face: usize,
        /// The vertex named.
        vertex: u32,
        /// Vertices that there are.
        vertices: usize,
    },
    /// Faces whose corners lie on a line, or coincide.
    #[error(
        "{count} faces of the {side} have no area, the first is face {first}, from 0: remove them \
         from the mesh"
    )]
    ZeroAreaFaces {
        /// Which mesh.
        side: Side,
        /// How many.
        count: usize,
        /// Position of the first, from 0.
        first: usize,
    },
    /// The surface is not whole.
    #[error(
        "the target mesh has {count} holes: close them, or let the points over them be skipped"
    )]
    MeshHoles {
        /// How many rims there are beyond the border of a sheet.
        count: usize,
    },
    /// An option is not usable.
    #[error("{option} cannot be {value}; it must be {}", option.range())]
    InvalidOption {
        /// Which one.
        option: OptionName,
        /// The value given.
        value: f64,
    },
    /// Too few points of the source are near the target, and over it rather than beside it.
    #[error(
        "only {used} of {points} points of the source lie over the target{}: start closer, or \
         allow larger distances", within(*max_distance_mm)
    )]
    NoOverlap {
        /// Points that took part.
        used: usize,
        /// Points of the source.
        points: usize,
        /// The limit on the distance, if one was set.
        max_distance_mm: Option<f64>,
    },
    /// The shape leaves a motion free.
    #[error(
        "the points leave {} free; hold it, give it a prior, or measure a part that shows it",
        directions.iter().map(ToString::to_string).collect::<Vec<_>>().join(" and ")
    )]
    Undetermined {
        /// One per free direction.
        directions: Vec<WeakDirection>,
    },
    /// The passes ran out before the motion fell below the tolerance.
    #[error(
        "not converged: pass {} still moved points by {:.1e} mm; allow more passes, a larger \
         tolerance, or start closer", best.iterations, best.last_motion_mm
    )]
    NotConverged {
        /// Where it came to.
        best: Box<Registration>,
    },
}

fn within(max_distance_mm: Option<f64>) -> String {
    max_distance_mm.map_or_else(String::new, |limit| format!(" within {limit} mm"))
}

/// An option that can be out of range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum OptionName {
    /// `tolerance_mm`.
    Tolerance,
    /// `sigma_mm`.
    Sigma,
    /// `max_distance_mm`.
    MaxDistance,
    /// `keep_share`.
    Keep,
    /// The scale of `loss`.
    LossScale,
    /// `sigma` of a prior.
    PriorSigma,
    /// `start` or `pivot_mm`.
    Start,
    /// The edge of a voxel.
    VoxelEdge,
    /// The number of neighbours that a normal is estimated from.
    Neighbours,
}

impl OptionName {
    fn range(self) -> &'static str {
        match self {
            Self::Keep => "a share above 0 and up to 1",
            Self::Start => "finite",
            Self::Neighbours => "at least 3, and below the number of points",
            _ => "positive and finite",
        }
    }
}

impl fmt::Display for OptionName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Tolerance => "the tolerance",
            Self::Sigma => "the standard uncertainty",
            Self::MaxDistance => "the largest distance",
            Self::Keep => "the share of matches to keep",
            Self::LossScale => "the scale of the loss",
            Self::PriorSigma => "the standard uncertainty of a prior",
            Self::Start => "a number of the start pose or the pivot",
            Self::VoxelEdge => "the edge of a voxel",
            Self::Neighbours => "the number of neighbours",
        })
    }
}
