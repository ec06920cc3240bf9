use crate::discretise::{Step, bilinear, exact_hold};
use crate::error::{require_not_negative, require_positive};
use crate::{ForceImpedanceError, ImpedanceParameters};

/// How the differential equation becomes one of differences.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Discretisation {
    /// The exact solution for a force error that is constant between samples.
    #[default]
    ExactHold,
    /// The trapezoidal rule (Tustin).
    Bilinear,
}

/// Impedance parameters, checked and turned into one step of a sampled controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impedance {
    pub(crate) parameters: ImpedanceParameters,
    pub(crate) interval_s: f64,
    pub(crate) step: Step,
}

impl Impedance {
    /// Checks the parameters and computes the step for a sampling interval.
    ///
    /// # Errors
    ///
    /// [`ForceImpedanceError::InvalidSetting`], and [`ForceImpedanceError::TooFastForSampling`]
    /// when the impedance rings faster than samples can show.
    pub fn new(
        parameters: ImpedanceParameters,
        interval_s: f64,
        discretisation: Discretisation,
    ) -> Result<Self, ForceImpedanceError> {
        require_positive("mass_kg", parameters.mass_kg)?;
        require_positive("damping_ns_per_mm", parameters.damping_ns_per_mm)?;
        require_not_negative("stiffness_n_per_mm", parameters.stiffness_n_per_mm)?;
        require_positive("interval_s", interval_s)?;
        let step = match discretisation {
            Discretisation::ExactHold => exact_hold(&parameters, interval_s)?,
            Discretisation::Bilinear => bilinear(&parameters, interval_s),
        };
        if !step.is_finite() {
            let damping = parameters.damping_ns_per_mm;
            return Err(ForceImpedanceError::InvalidSetting {
                setting: "damping_ns_per_mm",
                value: damping,
                needs: "of a size at which one step does not overflow, beside mass_kg and \
                        stiffness_n_per_mm",
            });
        }
        Ok(Self { parameters, interval_s, step })
    }

    /// The parameters it was made of.
    #[must_use]
    pub const fn parameters(&self) -> &ImpedanceParameters {
        &self.parameters
    }

    /// Sampling interval.
    #[must_use]
    pub const fn interval_s(&self) -> f64 {
        self.interval_s
    }

    /// One interval on: offset and speed from offset, speed, and the force error at this sample
    /// and the one before.
    #[inline]
    #[must_use]
    pub fn advance(
        &self,
        offset_mm: f64,
        speed_mm_per_s: f64,
        error_n: f64,
        error_before_n: f64,
    ) -> [f64; 2] {
        self.step.advance(offset_mm, speed_mm_per_s, error_n, error_before_n)
    }
}
