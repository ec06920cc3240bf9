use std::fmt;

/// Why there is no answer to rely on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FtCenterError {
    /// A number is NaN or infinite.
    #[error("value {} is not finite", index + 1)]
    NotFinite {
        /// Position in the input.
        index: usize,
    },
    /// A setting that must be positive and finite is not.
    #[error("{setting} must be positive and finite, got {value}")]
    NotPositive {
        /// Name of the setting.
        setting: &'static str,
        /// Its value.
        value: f64,
    },
    /// The force is under the gate: there is no contact to locate.
    #[error("no contact: |fz| = {:.4} N is under the gate of {min_fz_n:.4} N", fz_n.abs())]
    NoContact {
        /// Force along the sensor's z.
        fz_n: f64,
        /// The gate.
        min_fz_n: f64,
    },
    /// Too few samples of a record are in contact.
    #[error(
        "{contact} of {given} samples are in contact (|fz| of at least {min_fz_n:.4} N), need \
         {needed}: press longer or harder, or lower the gate min_fz_n"
    )]
    TooFewContactSamples {
        /// Samples in contact.
        contact: usize,
        /// Samples given.
        given: usize,
        /// Samples needed.
        needed: usize,
        /// The gate.
        min_fz_n: f64,
    },
    /// Samples over the gate both push and pull: no press.
    #[error(
        "fz is positive in {positive} and negative in {negative} samples over the gate of \
         {min_fz_n:.4} N: a press has one sign; tare the sensor or raise the gate min_fz_n"
    )]
    MixedSign {
        /// Samples with positive force.
        positive: usize,
        /// Samples with negative force.
        negative: usize,
        /// The gate.
        min_fz_n: f64,
    },
    /// Time stands still or runs backwards.
    #[error("time does not increase at sample {}: {before_s} s, then {after_s} s", index + 1)]
    TimeNotIncreasing {
        /// Position of the later sample.
        index: usize,
        /// Time of the sample before.
        before_s: f64,
        /// Time of this sample.
        after_s: f64,
    },
    /// The height of the contact plane is not finite.
    #[error("z0_mm must be finite, got {z0_mm}")]
    InvalidHeight {
        /// Height given.
        z0_mm: f64,
    },
    /// The monitor would lift before it touches.
    #[error("lift_fz_n of {lift_fz_n} N is above touch_fz_n of {touch_fz_n} N")]
    LiftAboveTouch {
        /// Force under which the head counts as lifted.
        lift_fz_n: f64,
        /// Force from which it counts as touching.
        touch_fz_n: f64,
    },
    /// A record covers too little of a turn to tell its centre from the wobble.
    #[error("record covers {turns:.3} turns at the given spin, need 1: press longer")]
    TooFewTurns {
        /// Turns covered.
        turns: f64,
    },
    /// Numbers are so large or small that results overflow.
    #[error("values are so large or so small that the result overflows: check the units")]
    OutOfRange,
    /// The record of one press cannot be used.
    #[error("press {name}: {source}")]
    Press {
        /// Name of the press.
        name: String,
        /// What is wrong with it.
        source: Box<FtCenterError>,
    },
    /// The machine position of a press is not finite.
    #[error("press {name}: its machine position is not finite")]
    PressPosition {
        /// Name of the press.
        name: String,
    },
    /// The frame needs more presses at known positions.
    #[error("{got} presses at known positions (use = frame), need {needed}")]
    TooFewFramePoints {
        /// Points given.
        got: usize,
        /// Points needed.
        needed: usize,
    },
    /// All points are in one place, so that the rotation about it is free.
    #[error(
        "frame presses lie within {spread_mm:.3e} mm of each other: the angle of the frame is \
         free; press at positions farther apart"
    )]
    CoincidentPoints {
        /// Root mean square distance from the centroid.
        spread_mm: f64,
    },
    /// What the points' own covariances leave of the rotation is no angle any more.
    #[error(
        "the angle of the frame is free: its standard uncertainty is {std_angle_rad:.1e} rad, with presses within \
         {spread_mm:.3e} mm of each other and centres of pressure as uncertain as their covariances say; press at \
         positions farther apart, harder or longer"
    )]
    AngleFree {
        /// Standard uncertainty of the angle.
        std_angle_rad: f64,
        /// Root mean square distance from the centroid.
        spread_mm: f64,
    },
    /// The points are on one line, so that the scale across it is free.
    #[error(
        "frame presses lie on one line (spread along and across {:.3e} and {:.3e} mm): the \
         affine map across it is free; press off the line", spreads_mm[0], spreads_mm[1]
    )]
    CollinearPoints {
        /// Root mean square spread along and across the line.
        spreads_mm: [f64; 2],
    },
    /// The uncertainty of the frame has no answer.
    #[error("frame: {0}")]
    Frame(#[from] Box<least_squares::SolveError>),
    /// A press is to place the sensor, and the frame is given.
    #[error(
        "press {name} is of use = frame, and the frame is taken from a solve before; mark presses \
         at known positions use = check, or leave the saved frame out"
    )]
    FrameGiven {
        /// Name of the press.
        name: String,
    },
    /// The covariance of a frame is no covariance, or leaves its angle free.
    #[error(
        "the covariance of the frame is none, or leaves its angle free (standard uncertainty \
         {std_angle_rad:.3e} rad)"
    )]
    InvalidFrameCovariance {
        /// Standard uncertainty of the angle; NaN where its variance is negative.
        std_angle_rad: f64,
    },
    /// A covariance is not positive definite.
    #[error("covariance of point {} is not positive definite", index + 1)]
    InvalidCovariance {
        /// Position in the input.
        index: usize,
    },
    /// A pressure gradient lifts the pad off, so that the formula does not hold.
    #[error(
        "pressure gradient {gradient_per_mm} /mm over a radius of {radius_mm} mm lifts the pad \
         off; the centroid formulas need |gradient|·radius ≤ 1"
    )]
    PadLiftsOff {
        /// Relative pressure gradient.
        gradient_per_mm: f64,
        /// Radius of the pad.
        radius_mm: f64,
    },
    /// The line of action does not meet the workpiece, or not in a usable way.
    #[error("line of action and workpiece: {0}")]
    Surface(#[from] geometry::GeometryError),
    /// Contact on a curved surface did not settle.
    #[error("contact point still moves by {step_mm:.3e} mm after {iterations} iterations")]
    ContactNotConverged {
        /// Last step.
        step_mm: f64,
        /// Iterations made.
        iterations: usize,
    },
    /// Arrays that belong together have different lengths.
    #[error("arrays have {lengths:?} entries; they must be equally long")]
    UnequalLengths {
        /// Length of each array.
        lengths: Vec<usize>,
    },
    /// Nothing was given.
    #[error("no {of} given")]
    Empty {
        /// What is missing.
        of: Table,
    },
    /// The poses leave a parameter free.
    #[error(
        "the poses do not determine {parameter} (singular values {largest:.3e} to \
         {smallest:.3e}): tilt the sensor into more directions"
    )]
    PosesNotEnough {
        /// The free parameter.
        parameter: &'static str,
        /// Largest singular value of the scaled design.
        largest: f64,
        /// Smallest singular value of the scaled design.
        smallest: f64,
    },
    /// The tool has no weight that could be located.
    #[error("weight of {weight_n:.3e} N is nothing beside the forces read: is a tool mounted?")]
    NoWeight {
        /// Weight found.
        weight_n: f64,
    },
    /// A covariate has not one value per observation.
    #[error("covariate {name} has {got} values for {needed} observations")]
    CovariateLength {
        /// Name of the column.
        name: String,
        /// Values given.
        got: usize,
        /// Values needed.
        needed: usize,
    },
}

/// What kind of rows an error speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Table {
    /// Presses.
    Presses,
    /// Displacements.
    Displacements,
    /// Static poses.
    Poses,
    /// Samples.
    Samples,
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Presses => "presses",
            Self::Displacements => "displacements",
            Self::Poses => "poses",
            Self::Samples => "samples",
        })
    }
}

pub(crate) fn require_positive(value: f64, setting: &'static str) -> Result<(), FtCenterError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(FtCenterError::NotPositive { setting, value })
    }
}
