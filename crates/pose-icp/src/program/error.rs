/// Why a program could not be corrected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProgramError {
    /// A block that a rigid motion does not turn into another block.
    #[error("line {line}: {reason}")]
    Line {
        /// From 1.
        line: usize,
        /// What it is that cannot be corrected.
        reason: Refused,
    },
    /// A tolerance or a number of decimals makes no sense.
    #[error("{name} must be {needed}, got {value}")]
    InvalidOption {
        /// Which.
        name: &'static str,
        /// What it must be.
        needed: &'static str,
        /// What it is.
        value: f64,
    },
}

/// What cannot be corrected in a block.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Refused {
    /// A preparatory function with a meaning of its own for coordinates.
    #[error("G{code} cannot be corrected; write it out as G0 to G3")]
    Code {
        /// Its number.
        code: f64,
    },
    /// A rotary or secondary axis.
    #[error("axis {axis} cannot be corrected: only X, Y and Z are moved")]
    Axis {
        /// Its letter.
        axis: char,
    },
    /// A move before all coordinates are known, or after a touch that ended anywhere.
    #[error(
        "the position is not known here; give X, Y and Z in the first move, and after a touch (G38.2 \
         to G38.5) those that it moved"
    )]
    UnknownPosition,
    /// Coordinates without a motion that they belong to.
    #[error("coordinates without a motion; give G0 to G3 before")]
    NoMotion,
    /// A word that is no letter with a number.
    #[error("cannot be read from {text:?} on; macros and expressions have to be resolved before")]
    Word {
        /// What stands there.
        text: String,
    },
    /// An arc whose ends are not as far from its centre.
    #[error("arc of radius {start} at its start and {end} at its end")]
    Arc {
        /// Distance of the start from the centre.
        start: f64,
        /// Distance of the end from the centre.
        end: f64,
    },
    /// A corrected coordinate that no machine has.
    #[error("{axis} would go to {value:e} mm; lengths beyond {limit:e} mm are slips")]
    TooFar {
        /// Its letter.
        axis: char,
        /// Where it would go, in mm.
        value: f64,
        /// Largest length accepted, in mm.
        limit: f64,
    },
    /// An arc that the chords allowed do not follow closely enough.
    #[error("the arc takes more than {limit:e} chords; allow them a larger distance from it")]
    TooManyChords {
        /// Most chords of one arc.
        limit: f64,
    },
    /// An arc without a centre or radius.
    #[error("arc without a centre (I, J, K) or a radius R that spans its ends")]
    NoCenter,
}
