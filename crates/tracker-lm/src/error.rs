use std::fmt;

use least_squares::{FreeDirection, Report};

/// Why the axis could not be calibrated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrackerError {
    /// The axis has no direction.
    #[error(
        "the axis needs a finite origin and a direction of some length, got direction \
         ({}, {}, {})", direction[0], direction[1], direction[2]
    )]
    InvalidAxis {
        /// The direction given.
        direction: [f64; 3],
    },
    /// A number is not finite, or larger than any machine.
    #[error("{what} {}: {value} is not a finite number below {limit:.0e}", index + 1)]
    InvalidNumber {
        /// What kind of record it stands in.
        what: Record,
        /// Position among its kind, from 0.
        index: usize,
        /// The number.
        value: f64,
        /// Largest magnitude that is accepted.
        limit: f64,
    },
    /// A standard uncertainty is not positive and finite.
    #[error("standard uncertainty {which} is {value} mm; it must be positive and finite")]
    InvalidNoise {
        /// Which one.
        which: &'static str,
        /// Its value.
        value: f64,
    },
    /// A reading refers to a station, mount or step that does not exist.
    #[error(
        "reading {} refers to index {index} of {what}s, but there are only {count}, counted from 0",
        range + 1
    )]
    UnknownIndex {
        /// Position of the reading, from 0.
        range: usize,
        /// What it refers to.
        what: Record,
        /// The index given.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// The same target point measured twice from one station.
    #[error(
        "station {station} has two readings of mount {mount} at step {step}; a target point seen \
         again needs a step of its own"
    )]
    DuplicateRange {
        /// Name of the station.
        station: String,
        /// Name of the mount.
        mount: String,
        /// Name of the step.
        step: String,
        /// Position of the second one, from 0.
        range: usize,
    },
    /// A station, mount or step that nothing was measured of.
    #[error("{what} {name} has no readings; measure it or leave it out")]
    Unseen {
        /// What it is.
        what: Record,
        /// Its name.
        name: String,
    },
    /// Too few stations: distances from three determine a point, and nothing checks the stations.
    #[error(
        "{got} stations cannot calibrate themselves, {needed} are needed: with fewer, the \
         position of the stations themselves is free"
    )]
    TooFewStations {
        /// Fewest.
        needed: usize,
        /// Stations given.
        got: usize,
    },
    /// Too few reflectors to see all six errors.
    #[error(
        "{got} reflectors do not show six errors, {needed} are needed: the rotation about the \
         line through two is free"
    )]
    TooFewMounts {
        /// Fewest.
        needed: usize,
        /// Reflectors given.
        got: usize,
    },
    /// The reflectors lie on one line.
    #[error(
        "the reflectors lie on one line (spread about it {off_line_mm:.4} mm of {along_mm:.1} mm): \
         the rotation about ({:.3}, {:.3}, {:.3}) is free; move one off the line",
        line[0], line[1], line[2]
    )]
    CollinearMounts {
        /// Root-mean-square spread along the line.
        along_mm: f64,
        /// Root-mean-square spread about the line.
        off_line_mm: f64,
        /// Unit vector along the line, in the frame that turns with the axis.
        line: [f64; 3],
    },
    /// Free target points leave every angle its errors.
    #[error(
        "free target points give every angle six errors of its own: a perfect axis needs the joint \
         formulation"
    )]
    PerfectAxisOfFreePoints,
    /// Two axes are calibrated with six free errors each in the joint bundle.
    #[error(
        "both axes of a head are calibrated in the joint formulation with six free errors each: \
         take one axis alone for another model, and declare where both are"
    )]
    TwoAxesOtherwise,
    /// The second axis has an angle for another number of steps.
    #[error("{got} angles of the second axis for {needed} steps")]
    SecondAngles {
        /// Steps.
        needed: usize,
        /// Angles.
        got: usize,
    },
    /// One of two axes never turned.
    #[error(
        "axis {letter} stands at {angle_deg:.4}° at every step: its errors, its place and its direction \
         are free; measure it at other angles while the other axis stands, or declare the other axis \
         alone"
    )]
    AxisStands {
        /// Its letter.
        letter: char,
        /// Where it stands.
        angle_deg: f64,
    },
    /// A step at which neither of two axes stands where it does while the other turns.
    #[error(
        "step {step}: both axes are away from where they stand while the other turns \
         ({first_deg:.4}° and {second_deg:.4}°): such a step shows the errors of both together; leave it \
         out"
    )]
    BothAxesTurned {
        /// Name of the step.
        step: String,
        /// Where the first stands.
        first_deg: f64,
        /// Where the second stands.
        second_deg: f64,
    },
    /// The pose that ties the two axes together was not measured.
    #[error(
        "no step at {first_deg:.4}° of the first and {second_deg:.4}° of the second axis, where each \
         stands while the other turns: how the errors of one lie to those of the other is free; measure \
         the reflectors there"
    )]
    NoCommonPose {
        /// Where the first stands.
        first_deg: f64,
        /// Where the second stands.
        second_deg: f64,
    },
    /// Nothing is declared of where the axis is, and the readings do not say it.
    #[error(
        "the readings do not say where the axis is: a point on it is free; declare where the \
         drawing has it, or measure more angles from more stations"
    )]
    AxisNotFound,
    /// The stations' nominal positions lie on one line, so that the rotation about it is free.
    #[error("the stations lie on one line: the rotation about it is free; move one off the line")]
    CollinearStations,
    /// The equations are fewer than the unknowns, or as many.
    #[error(
        "{equations} equations cannot determine {unknowns} unknowns and check them: \
         {shortage} {needed} would do, got {got}"
    )]
    TooFewRanges {
        /// Ranges and other rows.
        equations: usize,
        /// Stations, dead paths, reflectors and errors, or points.
        unknowns: usize,
        /// The count that is short.
        shortage: Shortage,
        /// Fewest of it that would do with everything else as it is.
        needed: usize,
        /// What there is of it.
        got: usize,
    },
    /// The readings at one angle do not show all six errors.
    #[error(
        "the readings at {angle_deg}° leave {} free; measure more reflectors there, or from more \
         stations",
        Names(free)
    )]
    UndeterminedAngle {
        /// The angle.
        angle_deg: f64,
        /// Names of the errors that take part in the free motion, the largest share first.
        free: Vec<String>,
    },
    /// The points of the first angle, which the free-points formulation refers to, are too few.
    #[error(
        "only {got} reflectors were seen at the first angle, {needed} are needed there; measure \
         the others too, or use the joint formulation"
    )]
    TooFewAtReference {
        /// Fewest.
        needed: usize,
        /// Reflectors seen there.
        got: usize,
    },
    /// A time or a covariate does not have one finite value per range.
    #[error("times and covariates need one finite value for each of {needed} readings")]
    InvalidCovariate {
        /// Ranges given.
        needed: usize,
    },
    /// The data leave something free.
    #[error(
        "the readings leave {} free; add stations, angles or reflectors that see it, or another \
         gauge",
        Directions(directions)
    )]
    Unobservable {
        /// One per free direction.
        directions: Vec<FreeDirection>,
    },
    /// The search did not settle.
    #[error(
        "not converged after {} iterations: check that the nominal positions are within some \
         centimetres and that every displacement belongs to its station and mount",
        report.iterations
    )]
    NotConverged {
        /// How far the search came.
        report: Box<Report>,
    },
    /// A residual or its derivative is not finite.
    #[error("a target lies in a station: check the nominal positions")]
    NotFinite,
}

/// What a record is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Record {
    /// A place of the tracer.
    Station,
    /// A place of a reflector.
    Mount,
    /// A stop of the axis.
    Step,
    /// A range.
    Range,
    /// A target point in the frame of a station.
    Target,
}

/// A count that is short.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Shortage {
    /// Angles.
    Angles,
    /// Ranges at each angle, on average.
    RangesPerAngle,
}

impl fmt::Display for Record {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Station => "station",
            Self::Mount => "mount",
            Self::Step => "step",
            Self::Range => "range",
            Self::Target => "target",
        })
    }
}

impl fmt::Display for Shortage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Angles => "too few angles,",
            Self::RangesPerAngle => "too few ranges at each angle,",
        })
    }
}

struct Names<'a>(&'a [String]);

impl fmt::Display for Names<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.join(", "))
    }
}

struct Directions<'a>(&'a [FreeDirection]);

impl fmt::Display for Directions<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, direction) in self.0.iter().enumerate() {
            write!(f, "{}{direction}", if i == 0 { "" } else { " and " })?;
        }
        Ok(())
    }
}
