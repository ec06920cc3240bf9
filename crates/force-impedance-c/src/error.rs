use core::ffi::c_char;

use force_impedance::ForceImpedanceError;

/// What a function says.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FiError {
    /// Done.
    None = 0,
    /// A pointer is null or misaligned.
    BadPointer = 1,
    /// The storage was not initialised by this version of the library.
    NotInitialised = 2,
    /// A setting is out of range; `fi_explain` says which.
    InvalidSetting = 3,
    /// A vector is not of unit length.
    NotAUnitVector = 4,
    /// A number is NaN or infinite.
    NotFinite = 5,
    /// The three legs leave a tilt of the head free.
    LegsDoNotHold = 6,
    /// A leg would be shorter or longer than it can be.
    LegOutOfRange = 7,
    /// The axial unit would be shorter or longer than it can be.
    AxialOutOfRange = 8,
    /// The head would lean farther than its joint allows.
    TiltOutOfRange = 9,
    /// The lengths fit no pose.
    ForwardNotConverged = 10,
    /// The impedance rings faster than the samples can follow.
    TooFastForSampling = 11,
    /// The surface is nearly along the tool.
    NormalAcrossAxis = 12,
    /// Something that this version of the interface has no name for.
    Unnamed = 13,
}

impl From<ForceImpedanceError> for FiError {
    fn from(error: ForceImpedanceError) -> Self {
        match error {
            ForceImpedanceError::InvalidSetting { .. } => Self::InvalidSetting,
            ForceImpedanceError::NotAUnitVector { .. } => Self::NotAUnitVector,
            ForceImpedanceError::NotFinite { .. } => Self::NotFinite,
            ForceImpedanceError::LegsDoNotHold { .. } => Self::LegsDoNotHold,
            ForceImpedanceError::LegOutOfRange { .. } => Self::LegOutOfRange,
            ForceImpedanceError::AxialOutOfRange { .. } => Self::AxialOutOfRange,
            ForceImpedanceError::TiltOutOfRange { .. } => Self::TiltOutOfRange,
            ForceImpedanceError::ForwardNotConverged { .. } => Self::ForwardNotConverged,
            ForceImpedanceError::TooFastForSampling { .. } => Self::TooFastForSampling,
            ForceImpedanceError::NormalAcrossAxis { .. } => Self::NormalAcrossAxis,
            _ => Self::Unnamed,
        }
    }
}

/// A code in words, a string that lives for ever; any number may be asked for.
#[unsafe(no_mangle)]
pub extern "C" fn fi_error_text(code: u32) -> *const c_char {
    let text = match code {
        0 => c"done",
        1 => c"a pointer is null or misaligned",
        2 => c"the storage was not initialised by this version of the library",
        3 => c"a setting is out of range: fi_explain says which",
        4 => c"a vector is not of unit length",
        5 => c"a number is NaN or infinite",
        6 => c"the three legs leave a tilt of the head free: spread the leg angles",
        7 => c"a leg would be shorter or longer than it can be",
        8 => c"the axial unit would be shorter or longer than it can be",
        9 => c"the head would lean farther than its joint allows",
        10 => c"no pose fits the lengths",
        11 => c"the impedance rings faster than the samples can follow: use more mass or damping",
        12 => c"the surface is nearly along the tool",
        _ => c"something that this version of the interface has no name for",
    };
    text.as_ptr()
}
