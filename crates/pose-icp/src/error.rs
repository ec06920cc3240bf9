use std::fmt;

use geometry::GeometryError;

use crate::{PoseParameter, WeakMotion};

/// Why no pose could be estimated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseError {
    /// The nominal surface makes no part.
    #[error("{0}")]
    Surface(#[from] GeometryError),
    /// Fewer points than unknowns.
    #[error(
        "{parameters} unknowns of the pose need at least as many touches, got {got}{}; touch more \
         points, or hold what is known",
        besides(*prior_rows)
    )]
    TooFewTouches {
        /// Touches given.
        got: usize,
        /// Equations that the side touches add.
        prior_rows: usize,
        /// Unknowns that are not held.
        parameters: usize,
    },
    /// A touch cannot be used.
    #[error("touch {}: {reason}", index + 1)]
    InvalidTouch {
        /// Position in the input slice, from 0; messages count from 1.
        index: usize,
        /// What is wrong with it.
        reason: InvalidTouch,
    },
    /// A number that is not a touch cannot be used.
    #[error("{name} must be {needed}, got {value}")]
    InvalidOption {
        /// Which.
        name: &'static str,
        /// What it must be.
        needed: &'static str,
        /// What it is.
        value: f64,
    },
    /// A touch has no closest point on the surface at the pose where the search starts.
    #[error(
        "touch {} has no closest point where the search starts ({source}); start closer",
        index + 1
    )]
    NoFoot {
        /// Position in the input slice, from 0; messages count from 1.
        index: usize,
        /// Why.
        source: GeometryError,
    },
    /// The ball touched beside the part, wherever the touches allow the part to lie.
    #[error(
        "touch {} lies outside the aperture: it meets the surface at ({x_mm:.3}, {y_mm:.3}) mm of \
         the workpiece, farther out than the place of the part is uncertain; check the part's \
         diameter and what is held, or remove the touch if the ball missed the part",
        index + 1
    )]
    OutsideAperture {
        /// Position in the input slice, from 0; messages count from 1.
        index: usize,
        /// Where it would touch, in the workpiece frame.
        x_mm: f64,
        /// Where it would touch, in the workpiece frame.
        y_mm: f64,
    },
    /// The tip is larger than the hollow it should touch.
    #[error(
        "a tip of radius {radius_mm} mm cannot touch the surface at touch {}, where its radius of \
         curvature is {curvature_radius_mm:.3} mm; use a smaller ball",
        index + 1
    )]
    TipTooLarge {
        /// Position in the input slice, from 0; messages count from 1.
        index: usize,
        /// Radius of the tip.
        radius_mm: f64,
        /// Least radius of curvature towards the ball.
        curvature_radius_mm: f64,
    },
    /// The data leave a motion of the workpiece free.
    #[error(
        "the touches do not determine {}; touch the sides of the part, hold a parameter, or \
         spread the touches",
        Listed(directions)
    )]
    Undetermined {
        /// One per free motion.
        directions: Vec<WeakMotion>,
    },
    /// The side touches do not lie around the part.
    #[error(
        "the side touches do not surround the part: touches {first} and {second} are {span_mm:.3} \
         mm apart along {axis}; give them in the order −y, +x, +y, −x (or its reverse), then the \
         centre"
    )]
    InvalidEdge {
        /// Axis along which the two should lie apart.
        axis: char,
        /// One of them, from 1.
        first: usize,
        /// The other, from 1.
        second: usize,
        /// How far apart they are along that axis.
        span_mm: f64,
    },
    /// The iteration did not settle.
    #[error(
        "not converged after {iterations} iterations ({rms_mm:.3e} mm rms); start closer to the \
         pose"
    )]
    NotConverged {
        /// Steps accepted.
        iterations: usize,
        /// Root-mean-square residual reached.
        rms_mm: f64,
    },
    /// A model sampled as finely as asked has more points than allowed.
    #[error(
        "the sampled model has {points:.3e} points, {gigabytes:.1} GB, more than the {limit:.3e} \
         allowed; sample it in two levels, or more coarsely"
    )]
    TooManyModelPoints {
        /// Points of the largest level.
        points: f64,
        /// Their memory.
        gigabytes: f64,
        /// Points allowed.
        limit: f64,
    },
    /// A covariate does not have one finite value per touch.
    #[error("covariate {covariate} needs one finite value for each of {needed} touches")]
    InvalidCovariate {
        /// Its name.
        covariate: String,
        /// Touches given.
        needed: usize,
    },
}

impl PoseError {
    /// Position in the input of the touch that is to blame, where one is.
    #[must_use]
    pub fn touch(&self) -> Option<usize> {
        match *self {
            Self::InvalidTouch { index, .. }
            | Self::NoFoot { index, .. }
            | Self::OutsideAperture { index, .. }
            | Self::TipTooLarge { index, .. } => Some(index),
            _ => None,
        }
    }
}

/// What is wrong with a touch.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InvalidTouch {
    /// A coordinate is NaN, infinite, or larger than any machine.
    #[error("coordinate {value} mm is not a finite number below {limit:.0e} mm")]
    Coordinate {
        /// The coordinate.
        value: f64,
        /// Largest magnitude that is accepted.
        limit: f64,
    },
    /// A standard uncertainty is not positive.
    #[error("standard uncertainty {sigma_mm} mm is not positive and finite")]
    Sigma {
        /// The standard uncertainty.
        sigma_mm: f64,
    },
}

fn besides(prior_rows: usize) -> String {
    if prior_rows == 0 { String::new() } else { format!(" and {prior_rows} from the side touches") }
}

struct Listed<'a>(&'a [WeakMotion]);

impl fmt::Display for Listed<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, direction) in self.0.iter().enumerate() {
            write!(f, "{}", if i == 0 { "" } else { " and " })?;
            let names = direction.components.iter().map(|c| c.parameter);
            for (k, name) in names.enumerate() {
                let name: PoseParameter = name;
                write!(f, "{}{}", if k == 0 { "" } else { " against " }, name.words())?;
            }
        }
        Ok(())
    }
}
