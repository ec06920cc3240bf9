use crate::error::{require, require_not_negative, require_positive};
use crate::{Discretisation, ForceImpedanceError};

/// What the correction is counted from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ReferenceMode {
    /// From where the tool stands each cycle: the spring holds nothing back, the force reaches
    /// its reference.
    #[default]
    Rebased,
    /// From the programmed path: the spring leaves the steady error
    /// `(F0 − F_r)/(1 + K_e/K)`.
    Absolute,
}

/// Limits and supervision of a [`Controller`](crate::Controller).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ControllerSettings {
    /// Nominal sampling interval.
    pub interval_s: f64,
    /// Kind of difference equation.
    pub discretisation: Discretisation,
    /// What the correction is counted from.
    pub mode: ReferenceMode,
    /// Force errors beyond ± this count as this.
    pub max_error_n: f64,
    /// References are brought between 0 and this.
    pub max_reference_n: f64,
    /// The reference in force approaches the one asked for at this rate.
    pub reference_rate_n_per_s: f64,
    /// Least and largest correction along the normal; negative is into the workpiece.
    pub travel_mm: [f64; 2],
    /// Fastest motion of the tip.
    pub rate_mm_per_s: f64,
    /// Fastest motion towards the workpiece while nothing is touched.
    pub approach_mm_per_s: f64,
    /// Under this normal force nothing is touched.
    pub contact_n: f64,
    /// Cells beyond ± this are broken.
    pub max_cell_n: f64,
    /// Largest disagreement between measured lengths and any pose.
    pub max_consistency_mm: f64,
    /// Largest angle between the outward normal and the tool's back direction.
    pub max_normal_rad: f64,
    /// Cycles with all four cells unchanged to the last bit after which they count as frozen.
    pub frozen_cycles: u32,
    /// Good cycles in a row after a fault before control resumes.
    pub recovery_cycles: u32,
}

impl Default for ControllerSettings {
    /// 1 kHz, exact hold, re-based; limits of a head that presses up to 200 N.
    fn default() -> Self {
        Self {
            interval_s: 1e-3,
            discretisation: Discretisation::ExactHold,
            mode: ReferenceMode::Rebased,
            // Twice a usual reference: more only makes the answer to a collision faster than the
            // legs can follow.
            max_error_n: 200.0,
            max_reference_n: 200.0,
            reference_rate_n_per_s: 500.0,
            travel_mm: [-5.0, 5.0],
            rate_mm_per_s: 50.0,
            // 5 µm a cycle: on a contact of 10 kN/mm, 50 N before the first answer.
            approach_mm_per_s: 5.0,
            // Ten times the noise of a cell of 0.1 N.
            contact_n: 1.0,
            max_cell_n: 2000.0,
            max_consistency_mm: 0.2,
            max_normal_rad: core::f64::consts::FRAC_PI_3,
            // Noise of one digit changes four cells within a few cycles.
            frozen_cycles: 50,
            recovery_cycles: 10,
        }
    }
}

impl ControllerSettings {
    pub(crate) fn check(&self) -> Result<(), ForceImpedanceError> {
        require_positive("interval_s", self.interval_s)?;
        require_positive("max_error_n", self.max_error_n)?;
        require_positive("max_reference_n", self.max_reference_n)?;
        require_positive("reference_rate_n_per_s", self.reference_rate_n_per_s)?;
        let [inward_mm, outward_mm] = self.travel_mm;
        require(inward_mm <= 0.0, "travel_mm[0]", inward_mm, "finite and not positive")?;
        require_not_negative("travel_mm[1]", outward_mm)?;
        require_positive("rate_mm_per_s", self.rate_mm_per_s)?;
        require(
            self.approach_mm_per_s > 0.0 && self.approach_mm_per_s <= self.rate_mm_per_s,
            "approach_mm_per_s",
            self.approach_mm_per_s,
            "positive and at most rate_mm_per_s",
        )?;
        require_positive("contact_n", self.contact_n)?;
        require_positive("max_cell_n", self.max_cell_n)?;
        require_positive("max_consistency_mm", self.max_consistency_mm)?;
        require(
            self.max_normal_rad > 0.0 && self.max_normal_rad < core::f64::consts::FRAC_PI_2,
            "max_normal_rad",
            self.max_normal_rad,
            "above 0 and below π/2",
        )?;
        let at_least = |least: u32, setting: &'static str, value: u32, needs: &'static str| {
            require(value >= least, setting, f64::from(value), needs)
        };
        at_least(2, "frozen_cycles", self.frozen_cycles, "2 or more")?;
        at_least(1, "recovery_cycles", self.recovery_cycles, "1 or more")
    }
}
