use core::fmt;

use crate::{Balance, ForwardPose};

/// From when on readings are warned about.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WarningLimits {
    /// Least internal force of the legs; below it their joints have play.
    pub min_preload_n: f64,
    /// Largest disagreement of the four lengths.
    pub max_consistency_mm: f64,
}

/// Something about the readings that a person should look at; the force is still computed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// The legs are not braced against each other.
    Preload {
        /// Internal force of the legs.
        preload_n: f64,
        /// Least internal force.
        min_n: f64,
    },
    /// The four lengths belong to no pose.
    Inconsistent {
        /// Disagreement along the direction that no motion can make.
        consistency_mm: f64,
        /// Largest disagreement.
        max_mm: f64,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Preload { preload_n, min_n } => write!(
                f,
                "legs are braced with {preload_n:.3} N only, {min_n} N asked for: their joints \
                 have play"
            ),
            Self::Inconsistent { consistency_mm, max_mm } => write!(
                f,
                "lengths disagree by {consistency_mm:.4} mm, {max_mm} mm allowed: check the \
                 zeros of the length sensors"
            ),
        }
    }
}

/// What the readings of one instant warn of, preload first.
#[must_use]
pub fn warnings(
    found: &ForwardPose,
    balance: &Balance,
    cells_n: &[f64; 4],
    limits: &WarningLimits,
) -> [Option<Warning>; 2] {
    let preload_n = balance.preload_n(cells_n);
    let consistency_mm = found.consistency_mm;
    // Negated, so that NaN is warned about.
    let braced = preload_n >= limits.min_preload_n;
    let consistent = consistency_mm.abs() <= limits.max_consistency_mm;
    [
        (!braced).then_some(Warning::Preload { preload_n, min_n: limits.min_preload_n }),
        (!consistent)
            .then_some(Warning::Inconsistent { consistency_mm, max_mm: limits.max_consistency_mm }),
    ]
}
