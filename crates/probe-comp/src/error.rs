use geometry::GeometryError;

/// Why ball centres could not be turned into contacts, or a probe not be qualified.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProbeError {
    /// The radius of the ball is no radius.
    #[error("tip radius {radius_mm} mm is not a finite number that is zero or positive")]
    InvalidTip {
        /// Radius given.
        radius_mm: f64,
    },
    /// A touch cannot be used.
    #[error("touch {}: {reason}", index + 1)]
    InvalidTouch {
        /// Position in the input.
        index: usize,
        /// What is wrong with it.
        reason: InvalidTouch,
    },
    /// A touch has no single closest point on the nominal surface.
    #[error("touch {} has no closest point on the nominal surface: {source}", index + 1)]
    NoFoot {
        /// Position in the input.
        index: usize,
        /// Why.
        source: GeometryError,
    },
    /// The ball is larger than the hollow it should touch.
    #[error(
        "a ball of radius {radius_mm} mm cannot touch the surface at touch {}, where it is hollow \
         with a radius of {hollow_radius_mm:.4} mm; use a smaller ball",
        index + 1
    )]
    TipTooLarge {
        /// Position in the input.
        index: usize,
        /// Radius of the ball.
        radius_mm: f64,
        /// Least radius of curvature towards the ball.
        hollow_radius_mm: f64,
    },
    /// The ball was nowhere near the surface.
    #[error(
        "touch {}: the ball's surface is {gap_mm:.3} mm from the nominal surface, more than \
         {limit_mm:.3} mm: check frame, units and side{}",
        index + 1,
        as_of_others(*far, *of)
    )]
    FarFromSurface {
        /// Position in the input.
        index: usize,
        /// Distance of the ball's surface, negative inside the part.
        gap_mm: f64,
        /// Largest distance accepted.
        limit_mm: f64,
        /// Touches that are as far.
        far: usize,
        /// Touches there are.
        of: usize,
    },
    /// A measured normal needs further touches around the one it belongs to.
    #[error("touch {} has {got} further touches around it; this normal needs {needed}", index + 1)]
    TooFewNeighbours {
        /// Position in the input.
        index: usize,
        /// Touches around it.
        got: usize,
        /// Fewest that the method works with.
        needed: usize,
    },
    /// The touches around one lie on a line, or coincide.
    #[error(
        "the touches around touch {} lie on a line, so the tilt about that line is free: they \
         spread by {major_mm:.2e} mm and {minor_mm:.2e} mm; place them on a circle",
        index + 1
    )]
    NeighboursOnALine {
        /// Position in the input.
        index: usize,
        /// Spread along the line.
        major_mm: f64,
        /// Spread across it.
        minor_mm: f64,
    },
    /// A direction of approach is asked for and not given.
    #[error(
        "touch {index} has no direction of approach (nx, ny, nz); record it, or compensate along the nominal normal"
    )]
    NoApproach {
        /// Position in the input.
        index: usize,
    },
    /// The ball cannot meet the part at its guide point, moving along z.
    #[error(
        "touch {}: moving along z at its guide point, the ball does not meet the part",
        index + 1
    )]
    NoGuide {
        /// Position in the input.
        index: usize,
    },
    /// A profile is too short, or its places do not increase.
    #[error("a profile needs at least 3 places in increasing order, got {got}")]
    InvalidProfile {
        /// Places given.
        got: usize,
    },
    /// A touch is not in the row of the others.
    #[error(
        "touch {} lies {off_mm} mm beside the row of the others; the normal of a profile needs touches \
         in one row of the xy plane",
        index + 1
    )]
    BesideProfile {
        /// Position in the input slice, from 0; messages count from 1.
        index: usize,
        /// How far.
        off_mm: f64,
    },
    /// Two touches of a profile are in one place.
    #[error(
        "touches {} and {} of the profile are in one place, which gives no slope; take one of them out",
        other + 1,
        index + 1
    )]
    SamePlace {
        /// Position of the later one in the input slice, from 0; messages count from 1.
        index: usize,
        /// Position of the other one.
        other: usize,
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
    /// The touches of an artefact leave something of the probe free.
    #[error("{}", unqualified(free))]
    NotQualified {
        /// Parameters that the touches do not show; empty where the search found no answer.
        free: Vec<String>,
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

fn unqualified(free: &[String]) -> String {
    let advice = "touch the artefact from more directions, or ask for fewer terms";
    if free.is_empty() {
        format!("no sphere or ring of this radius fits the touches; {advice}")
    } else {
        format!("the touches of the artefact leave {} free; {advice}", free.join(", "))
    }
}

impl ProbeError {
    /// Position in the input of the touch that is to blame, where one is.
    #[must_use]
    pub fn touch(&self) -> Option<usize> {
        match *self {
            Self::InvalidTouch { index, .. }
            | Self::NoFoot { index, .. }
            | Self::TipTooLarge { index, .. }
            | Self::FarFromSurface { index, .. }
            | Self::TooFewNeighbours { index, .. }
            | Self::NeighboursOnALine { index, .. }
            | Self::BesideProfile { index, .. }
            | Self::SamePlace { index, .. }
            | Self::NoApproach { index }
            | Self::NoGuide { index } => Some(index),
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
    /// The approach leads away from the part.
    #[error(
        "the approach points away from the part, {angle_deg:.1}° from the way to it; give it from \
         the ball towards the surface"
    )]
    LeadsAway {
        /// Angle between the approach and the way to the surface.
        angle_deg: f64,
    },
}

/// Touches as far as this one from which, and the share of all at which, they are no slip of one.
const FEWEST_FAR: usize = 3;
const ONE_IN: usize = 10;

/// What it means that others are as far.
fn as_of_others(far: usize, of: usize) -> String {
    if far < FEWEST_FAR || ONE_IN * far < of {
        return String::new();
    }
    format!(
        "; {far} of {of} touches are as far, as where touches or single coordinates are of another \
         session, or of rows in another order"
    )
}
