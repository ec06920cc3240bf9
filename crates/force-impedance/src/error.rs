/// Why there is no answer to rely on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ForceImpedanceError {
    /// A setting is outside the range in which it has a meaning.
    #[error("{setting} is {value}, must be {needs}")]
    InvalidSetting {
        /// Name of the setting.
        setting: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        needs: &'static str,
    },
    /// A vector is not of unit length.
    #[error("{vector} has length {length}, must be a unit vector")]
    NotAUnitVector {
        /// Name of the vector.
        vector: &'static str,
        /// Its length.
        length: f64,
    },
    /// A measured number is NaN or infinite.
    #[error("{quantity} {index} (counted from 1) is not finite")]
    NotFinite {
        /// What was measured.
        quantity: &'static str,
        /// Which one, counted from 1.
        index: usize,
    },
    /// The legs do not hold the head.
    #[error(
        "the three legs leave a tilt of the head free (smallest over largest singular value of \
         the leg Jacobian {relative_spread:.1e}): spread the leg angles"
    )]
    LegsDoNotHold {
        /// Smallest over largest singular value of the leg Jacobian.
        relative_spread: f64,
    },
    /// A leg would be shorter or longer than it can be.
    #[error("leg {leg} would be {length_mm:.4} mm, its range is {min_mm} to {max_mm} mm")]
    LegOutOfRange {
        /// Leg, 1 to 3.
        leg: usize,
        /// Length asked for.
        length_mm: f64,
        /// Shortest.
        min_mm: f64,
        /// Longest.
        max_mm: f64,
    },
    /// The axial unit would be shorter or longer than it can be.
    #[error("axial length would be {length_mm:.4} mm, its range is {min_mm} to {max_mm} mm")]
    AxialOutOfRange {
        /// Length asked for.
        length_mm: f64,
        /// Shortest.
        min_mm: f64,
        /// Longest.
        max_mm: f64,
    },
    /// The head would lean farther than its joint allows.
    #[error("head would lean by {tilt_rad:.4} rad, its joint allows {max_rad:.4} rad")]
    TiltOutOfRange {
        /// Tilt asked for.
        tilt_rad: f64,
        /// Largest.
        max_rad: f64,
    },
    /// The lengths fit no pose, or the start was too far from it.
    #[error(
        "no pose fits the lengths: the tip still moves by {step_mm:.1e} mm after {iterations} \
         iterations"
    )]
    ForwardNotConverged {
        /// Last step.
        step_mm: f64,
        /// Iterations made.
        iterations: usize,
    },
    /// The impedance rings faster than the samples can follow.
    #[error(
        "the impedance rings at {natural_hz:.3} Hz, samples show {nyquist_hz:.3} Hz at most: use \
         more mass or damping, or a shorter interval"
    )]
    TooFastForSampling {
        /// Natural frequency.
        natural_hz: f64,
        /// Half the sampling frequency.
        nyquist_hz: f64,
    },
    /// The surface is nearly along the tool, so that dividing by the cosine means nothing.
    #[error(
        "the normal is {angle_rad:.4} rad off the tool's axis: the published formula needs less \
         than {max_rad:.4} rad"
    )]
    NormalAcrossAxis {
        /// Angle between normal and axis.
        angle_rad: f64,
        /// Largest.
        max_rad: f64,
    },
    /// One sample of a log cannot be used.
    #[cfg(feature = "std")]
    #[error("sample {}: {source}", index + 1)]
    Sample {
        /// Position in the log.
        index: usize,
        /// What is wrong with it.
        source: Box<ForceImpedanceError>,
    },
    /// Time stands still or runs backwards within a segment.
    #[cfg(feature = "std")]
    #[error("time does not increase at sample {}: {before_s} s, then {after_s} s", index + 1)]
    TimeNotIncreasing {
        /// Position of the later sample.
        index: usize,
        /// Time before.
        before_s: f64,
        /// Time of this sample.
        after_s: f64,
    },
    /// A log is too short to be judged.
    #[cfg(feature = "std")]
    #[error("log has {got} samples, need {needed}: record longer")]
    TooFewSamples {
        /// Samples given.
        got: usize,
        /// Samples needed.
        needed: usize,
    },
    /// Only some samples have a reference.
    #[cfg(feature = "std")]
    #[error("{with} of {samples} samples have a reference force: all must have it, or none")]
    PartialReference {
        /// Samples with a reference.
        with: usize,
        /// All samples.
        samples: usize,
    },
    /// Runs that went over different parts of a path have nothing to repeat.
    #[cfg(feature = "std")]
    #[error(
        "the {runs} runs have no stretch of the path in common: one begins at {from_mm} mm, one \
         ends at {to_mm} mm; count the path from the same place in every run"
    )]
    NoCommonPath {
        /// Runs given.
        runs: usize,
        /// Where the last to begin begins.
        from_mm: f64,
        /// Where the first to end ends.
        to_mm: f64,
    },
    /// A covariate has not one value per sample.
    #[cfg(feature = "std")]
    #[error("covariate {name} has {got} values for {needed} samples")]
    CovariateLength {
        /// Name of the column.
        name: String,
        /// Values given.
        got: usize,
        /// Values needed.
        needed: usize,
    },
}

/// Checks that a setting is finite and `ok`.
pub(crate) fn require(
    ok: bool,
    setting: &'static str,
    value: f64,
    needs: &'static str,
) -> Result<(), ForceImpedanceError> {
    if ok && value.is_finite() {
        Ok(())
    } else {
        Err(ForceImpedanceError::InvalidSetting { setting, value, needs })
    }
}

pub(crate) fn require_positive(
    setting: &'static str,
    value: f64,
) -> Result<(), ForceImpedanceError> {
    require(value > 0.0, setting, value, "positive and finite")
}

pub(crate) fn require_not_negative(
    setting: &'static str,
    value: f64,
) -> Result<(), ForceImpedanceError> {
    require(value >= 0.0, setting, value, "finite and not negative")
}
