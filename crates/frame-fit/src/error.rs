use std::fmt;

use least_squares::FreeDirection;

use crate::{Handedness, Transform};

/// Why no transform could be estimated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrameFitError {
    /// Fewer points than the transform has to know.
    #[error("a {transform} transform needs at least {needed} points, got {got}")]
    TooFewPoints {
        /// The family asked for.
        transform: Transform,
        /// Fewest points that can determine it.
        needed: usize,
        /// Points given.
        got: usize,
    },
    /// A pair cannot be used.
    #[error("point pair {}: {reason}", index + 1)]
    InvalidPair {
        /// Position in the input slice.
        index: usize,
        /// What is wrong with it.
        reason: InvalidPair,
    },
    /// The points do not spread far enough: coincident, collinear or coplanar.
    #[error(
        "the points do not determine a {transform} transform: {free} is free (spread about the \
         centroid along the principal directions {} mm); add points that spread further, or fit \
         a smaller family",
        Numbers(spreads_mm)
    )]
    Degenerate {
        /// The family asked for.
        transform: Transform,
        /// Root-mean-square spread along the principal directions, the largest first; the
        /// singular values of the centred points over `√n`, of the frame where they are smaller.
        spreads_mm: Vec<f64>,
        /// What the points leave free.
        free: FreeMotion,
    },
    /// Two different rotations fit equally well: the points are not partners of each other.
    #[error(
        "two different rotations fit equally well (relative gap {relative_gap:.1e}): check that \
         the points are paired rightly"
    )]
    Ambiguous {
        /// Difference between the fit of the two, over what matching points would give.
        relative_gap: f64,
    },
    /// One frame mirrors the other, and no proper map (or no improper one, where that was asked
    /// for) can be estimated.
    #[error(
        "no {handedness} map can be estimated, it would miss by {rms_mm:.3} mm; one of the other \
         handedness misses by {other_rms_mm:.3} mm: check the signs of the axes, or fit that one"
    )]
    Mirrored {
        /// What was asked for.
        handedness: Handedness,
        /// Root-mean-square distance left by the best map of that handedness.
        rms_mm: f64,
        /// Root-mean-square distance left by the best map of the other handedness.
        other_rms_mm: f64,
    },
    /// The noise is as large as the spread of the points.
    #[error(
        "the noise leaves {parameter} about the centroid unknown (standard uncertainty \
         {sigma:.2}, spread of the points along the principal directions {} mm); add points that \
         spread further, or fit a smaller family",
        Numbers(spreads_mm)
    )]
    TooNoisy {
        /// The least known parameter.
        parameter: &'static str,
        /// Its standard uncertainty, in rad or as a ratio.
        sigma: f64,
        /// Root-mean-square spread along the principal directions, the largest first.
        spreads_mm: Vec<f64>,
    },
    /// The points under their weights leave a combination of parameters free, although they
    /// spread: those that do count too little, or a robust loss rejects them.
    #[error(
        "the points under their weights leave {} free; add points, or even out the uncertainties",
        directions.iter().map(ToString::to_string).collect::<Vec<_>>().join(" and ")
    )]
    Unobservable {
        /// One per free direction.
        directions: Vec<FreeDirection>,
    },
    /// The iteration did not settle.
    #[error(
        "not converged after {iterations} iterations (cost {cost:.3e}): the coordinates contradict \
         each other; look for a table from another session, another unit, labels or rows in another \
         order"
    )]
    NotConverged {
        /// Steps accepted.
        iterations: usize,
        /// Half the weighted sum of squares reached.
        cost: f64,
    },
    /// A robust loss needs a positive finite scale.
    #[error("robust loss needs a positive finite scale, got {scale}")]
    InvalidLoss {
        /// The scale given.
        scale: f64,
    },
    /// A pose has a coordinate that is not finite or too large, or no rotation.
    #[error("pose {}: position and rotation must be finite numbers", index + 1)]
    InvalidPose {
        /// Position in the input slice.
        index: usize,
    },
    /// A distance is not positive, or not between two places that poses touch.
    #[error(
        "distance {}: it must be positive, with a positive uncertainty, between two \
         different places that poses touch",
        index + 1
    )]
    InvalidDistance {
        /// Position in the input slice.
        index: usize,
    },
    /// Fewer poses than tip and places have to know.
    #[error("tip and places need at least {needed} poses, got {got}")]
    TooFewPoses {
        /// Fewest poses with any redundancy.
        needed: usize,
        /// Poses given.
        got: usize,
    },
    /// At every place the flange was turned about one direction only.
    #[error(
        "the tip along ({:.3}, {:.3}, {:.3}) of the flange is free: at every place the flange turned \
         about that direction only (spread across it {spread_rad:.1e} rad); hold the tip at a place \
         in poses that tilt the tool to several sides",
        direction[0], direction[1], direction[2]
    )]
    TipFree {
        /// Unit vector in the flange's frame.
        direction: [f64; 3],
        /// Spread of the rotations across it.
        spread_rad: f64,
    },
    /// A covariate does not have one finite value per point.
    #[error("covariate {covariate} needs one finite value for each of {needed} points")]
    InvalidCovariate {
        /// Its name.
        covariate: String,
        /// Points given.
        needed: usize,
    },
}

/// What is wrong with a point pair.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InvalidPair {
    /// A coordinate is NaN, infinite, or further away than the Moon.
    #[error("coordinate {value} mm is not a finite number below {limit:.0e} mm")]
    Coordinate {
        /// The coordinate.
        value: f64,
        /// Largest magnitude that is accepted.
        limit: f64,
    },
    /// A standard uncertainty is not positive, or beyond all measure.
    #[error(
        "standard uncertainty {sigma_mm} mm is not between {smallest:.0e} and {largest:.0e} mm"
    )]
    Sigma {
        /// The standard uncertainty; NaN where a variance is negative.
        sigma_mm: f64,
        /// Smallest that is accepted.
        smallest: f64,
        /// Largest that is accepted.
        largest: f64,
    },
    /// A covariance is not symmetric.
    #[error("covariance is not symmetric (off by {asymmetry_mm2:.1e} mm²)")]
    Asymmetric {
        /// Largest difference between mirrored entries.
        asymmetry_mm2: f64,
    },
    /// A covariance is not positive definite.
    #[error("covariance is not positive definite")]
    NotPositiveDefinite,
}

/// A motion that changes no residual.
#[derive(Clone, Debug, PartialEq)]
pub enum FreeMotion {
    /// Any rotation: the points coincide.
    EveryRotation,
    /// Rotation about the line through the points.
    RotationAbout {
        /// Unit vector along the line, in the source frame.
        axis: Vec<f64>,
    },
    /// Stretch and shear along a direction in which the points do not extend.
    MapAlong {
        /// Unit vector, in the source frame.
        direction: Vec<f64>,
    },
}

impl fmt::Display for FreeMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::EveryRotation => write!(f, "every rotation about the common point"),
            Self::RotationAbout { axis } => {
                write!(f, "the rotation about the line ({}) of the points", Numbers(axis))
            }
            Self::MapAlong { direction } => {
                write!(f, "stretch and shear along ({})", Numbers(direction))
            }
        }
    }
}

struct Numbers<'a>(&'a [f64]);

impl fmt::Display for Numbers<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, value) in self.0.iter().enumerate() {
            let separator = if i == 0 { "" } else { ", " };
            if *value == 0.0 || value.abs() >= 1e-3 {
                write!(f, "{separator}{value:.3}")?;
            } else {
                write!(f, "{separator}{value:.1e}")?;
            }
        }
        Ok(())
    }
}
