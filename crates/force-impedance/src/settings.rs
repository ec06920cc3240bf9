use crate::error::require;
use crate::motion::MotionLimits;
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
    /// Largest rate at which that rate changes.
    pub reference_acceleration_n_per_s2: f64,
    /// Largest rate at which that changes in turn.
    pub reference_jerk_n_per_s3: f64,
    /// Least and largest correction along the normal; negative is into the workpiece.
    pub travel_mm: [f64; 2],
    /// Fastest motion of the tip.
    pub rate_mm_per_s: f64,
    /// Largest acceleration of the tip, stopping on a fault included.
    pub acceleration_mm_per_s2: f64,
    /// Largest jerk of the tip.
    pub jerk_mm_per_s3: f64,
    /// Fastest motion towards the workpiece while nothing is touched.
    pub approach_mm_per_s: f64,
    /// Under this normal force nothing is touched.
    pub contact_n: f64,
    /// Cells at ± this and beyond are broken or at their end.
    pub max_cell_n: f64,
    /// Largest coefficient of friction that a contact can have.
    pub max_friction_ratio: f64,
    /// Force across the normal, beyond that friction, that errors of the cells and of the head's
    /// weight explain.
    pub max_disagreement_n: f64,
    /// Farthest way towards the workpiece without any change of the axial cell, where the normal is
    /// so near to the tool's axis that the legs do not feel a contact.
    pub max_blind_mm: f64,
    /// Largest disagreement between measured lengths and any pose.
    pub max_consistency_mm: f64,
    /// Largest angle between the outward normal and the tool's back direction.
    pub max_normal_rad: f64,
    /// Cycles with all four cells unchanged to the last bit after which they count as frozen.
    pub frozen_cycles: u32,
    /// Cycles in a row for which the cells disagree, or for which a cell that was alive does not
    /// change while others do, after which it counts as a fault.
    pub suspect_cycles: u32,
    /// Cycles for which the output is held while the force is not known; after them the tip
    /// retracts.
    pub hold_cycles: u32,
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
            // Wide: the rate alone shapes the ramp, within a cycle.
            reference_acceleration_n_per_s2: 1e9,
            reference_jerk_n_per_s3: 1e13,
            travel_mm: [-5.0, 5.0],
            rate_mm_per_s: 50.0,
            // 1 g: from the rate to rest in 6 ms and 0.15 mm. What the impedance asks for on a contact
            // in balance is far below it.
            acceleration_mm_per_s2: 1e4,
            // All of it within a cycle.
            jerk_mm_per_s3: 1e7,
            // 5 µm a cycle: on a contact of 10 kN/mm, 50 N before the first answer.
            approach_mm_per_s: 5.0,
            // Ten times the noise of a cell of 0.1 N.
            contact_n: 1.0,
            max_cell_n: 2000.0,
            // Twice that of a pad on glass.
            max_friction_ratio: 1.0,
            // Half of a usual head's weight, and a tenth of what its cells read.
            max_disagreement_n: 40.0,
            // 50 ms at the approach rate.
            max_blind_mm: 0.25,
            max_consistency_mm: 0.2,
            max_normal_rad: core::f64::consts::FRAC_PI_3,
            // Noise of one digit changes four cells within a few cycles.
            frozen_cycles: 50,
            // With what a change of speed takes, within 50 ms.
            suspect_cycles: 40,
            hold_cycles: 50,
            recovery_cycles: 10,
        }
    }
}

/// No head presses with more than this: the weight of a thousand tonnes.
const MAX_FORCE_N: f64 = 1e7;
/// A reference that changes faster than this steps from nothing to [`MAX_FORCE_N`] in 10 ns.
const MAX_FORCE_RATE_N_PER_S: f64 = 1e15;
/// No head is larger.
const MAX_LENGTH_MM: f64 = 1e5;
/// Faster than sound in air is no motion of a polishing tool.
const MAX_SPEED_MM_PER_S: f64 = 1e6;
/// A drive of 10⁶ g does not exist.
const MAX_ACCELERATION_MM_PER_S2: f64 = 1e10;
/// The largest acceleration within a microsecond.
const MAX_JERK_MM_PER_S3: f64 = 1e16;
/// Sampling between 1 MHz and 0.1 Hz.
const INTERVAL_S: [f64; 2] = [1e-6, 10.0];
/// Glue has less.
const MAX_FRICTION_RATIO: f64 = 100.0;
/// A motion that needs more cycles than this to stop is none of a controller.
const MAX_LAG_CYCLES: f64 = 1e5;

impl ControllerSettings {
    /// Bounds of the tip's motion.
    pub(crate) fn tip_motion(&self) -> MotionLimits {
        let [inward_mm, outward_mm] = self.travel_mm;
        // There and back, and a way for heads without travel.
        let span_mm = 2.0 * (outward_mm - inward_mm) + 1.0;
        MotionLimits::new(
            self.rate_mm_per_s,
            self.acceleration_mm_per_s2,
            self.jerk_mm_per_s3,
            span_mm,
            self.interval_s,
        )
    }

    /// Bounds of the reference in force.
    pub(crate) fn reference_motion(&self) -> MotionLimits {
        MotionLimits::new(
            self.reference_rate_n_per_s,
            self.reference_acceleration_n_per_s2,
            self.reference_jerk_n_per_s3,
            self.max_reference_n,
            self.interval_s,
        )
    }

    pub(crate) fn check(&self) -> Result<(), ForceImpedanceError> {
        let [shortest_s, longest_s] = INTERVAL_S;
        require(
            self.interval_s >= shortest_s && self.interval_s <= longest_s,
            "interval_s",
            self.interval_s,
            "from 1e-6 to 10",
        )?;
        self.check_forces()?;
        self.check_motion()?;
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
        at_least(2, "suspect_cycles", self.suspect_cycles, "2 or more")?;
        at_least(1, "recovery_cycles", self.recovery_cycles, "1 or more")
    }

    fn check_forces(&self) -> Result<(), ForceImpedanceError> {
        let force = |setting, value| {
            let needs = "positive and at most 1e7";
            require(value > 0.0 && value <= MAX_FORCE_N, setting, value, needs)
        };
        force("max_error_n", self.max_error_n)?;
        force("max_reference_n", self.max_reference_n)?;
        force("contact_n", self.contact_n)?;
        force("max_cell_n", self.max_cell_n)?;
        force("max_disagreement_n", self.max_disagreement_n)?;
        let rate = |setting, value| {
            let needs = "positive and at most 1e15";
            require(value > 0.0 && value <= MAX_FORCE_RATE_N_PER_S, setting, value, needs)
        };
        rate("reference_rate_n_per_s", self.reference_rate_n_per_s)?;
        rate("reference_acceleration_n_per_s2", self.reference_acceleration_n_per_s2)?;
        rate("reference_jerk_n_per_s3", self.reference_jerk_n_per_s3)?;
        require(
            self.reference_motion().lag <= MAX_LAG_CYCLES,
            "reference_acceleration_n_per_s2",
            self.reference_acceleration_n_per_s2,
            "so large, and so the jerk, that the ramp ends within 1e5 cycles",
        )?;
        require(
            self.max_friction_ratio > 0.0 && self.max_friction_ratio <= MAX_FRICTION_RATIO,
            "max_friction_ratio",
            self.max_friction_ratio,
            "positive and at most 100",
        )
    }

    fn check_motion(&self) -> Result<(), ForceImpedanceError> {
        let [inward_mm, outward_mm] = self.travel_mm;
        require(
            (-MAX_LENGTH_MM..=0.0).contains(&inward_mm),
            "travel_mm[0]",
            inward_mm,
            "finite and not positive, -1e5 at least",
        )?;
        require(
            (0.0..=MAX_LENGTH_MM).contains(&outward_mm),
            "travel_mm[1]",
            outward_mm,
            "finite and not negative, 1e5 at most",
        )?;
        let length = |setting, value| {
            let needs = "positive and at most 1e5";
            require(value > 0.0 && value <= MAX_LENGTH_MM, setting, value, needs)
        };
        length("max_consistency_mm", self.max_consistency_mm)?;
        length("max_blind_mm", self.max_blind_mm)?;
        require(
            self.rate_mm_per_s > 0.0 && self.rate_mm_per_s <= MAX_SPEED_MM_PER_S,
            "rate_mm_per_s",
            self.rate_mm_per_s,
            "positive and at most 1e6",
        )?;
        require(
            self.approach_mm_per_s > 0.0 && self.approach_mm_per_s <= self.rate_mm_per_s,
            "approach_mm_per_s",
            self.approach_mm_per_s,
            "positive and at most rate_mm_per_s",
        )?;
        require(
            self.acceleration_mm_per_s2 > 0.0
                && self.acceleration_mm_per_s2 <= MAX_ACCELERATION_MM_PER_S2,
            "acceleration_mm_per_s2",
            self.acceleration_mm_per_s2,
            "positive and at most 1e10",
        )?;
        require(
            self.jerk_mm_per_s3 > 0.0 && self.jerk_mm_per_s3 <= MAX_JERK_MM_PER_S3,
            "jerk_mm_per_s3",
            self.jerk_mm_per_s3,
            "positive and at most 1e16",
        )?;
        require(
            self.tip_motion().lag <= MAX_LAG_CYCLES,
            "acceleration_mm_per_s2",
            self.acceleration_mm_per_s2,
            "so large, and so the jerk, that a stop takes less than 1e5 cycles",
        )
    }
}
