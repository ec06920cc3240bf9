use force_impedance::{ControllerSettings, Discretisation, ImpedanceParameters, ReferenceMode};

use crate::FiError;
use crate::pointer::{Output, code};

/// How the contact is to feel: `M E'' + D E' + K E = F_n − F_r`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiImpedance {
    /// M, positive.
    pub mass_kg: f64,
    /// D, positive.
    pub damping_ns_per_mm: f64,
    /// K, zero or more.
    pub stiffness_n_per_mm: f64,
}

/// How the differential equation becomes one of differences.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FiDiscretisation {
    /// The exact solution for a force error held between samples.
    ExactHold = 0,
    /// The trapezoidal rule.
    Bilinear = 1,
}

/// What the correction is counted from.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FiMode {
    /// From where the tool stands each cycle: the force reaches its reference.
    Rebased = 0,
    /// From the programmed path: the spring leaves a steady error.
    Absolute = 1,
}

/// Limits and supervision of a controller; start from `fi_settings_default`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiSettings {
    /// Nominal sampling interval.
    pub interval_s: f64,
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
    /// Force across the normal, beyond that friction, that errors explain.
    pub max_disagreement_n: f64,
    /// Farthest way towards the workpiece without any change of the axial cell, where the normal
    /// is along the tool.
    pub max_blind_mm: f64,
    /// Largest disagreement between measured lengths and any pose.
    pub max_consistency_mm: f64,
    /// Largest angle between the outward normal and the tool's back direction.
    pub max_normal_rad: f64,
    /// Cycles with all four cells unchanged to the last bit after which they count as frozen.
    pub frozen_cycles: u32,
    /// Cycles for which the cells disagree, or one alone is stuck, after which it is a fault.
    pub suspect_cycles: u32,
    /// Cycles for which the output is held while the force is not known, before the tip retracts.
    pub hold_cycles: u32,
    /// Good cycles in a row after a fault before control resumes.
    pub recovery_cycles: u32,
    /// An `FiDiscretisation`.
    pub discretisation: u32,
    /// An `FiMode`.
    pub mode: u32,
}

impl From<&FiImpedance> for ImpedanceParameters {
    fn from(p: &FiImpedance) -> Self {
        Self {
            mass_kg: p.mass_kg,
            damping_ns_per_mm: p.damping_ns_per_mm,
            stiffness_n_per_mm: p.stiffness_n_per_mm,
        }
    }
}

/// A mode by its number.
pub(crate) fn mode(number: u32) -> Result<ReferenceMode, FiError> {
    match number {
        0 => Ok(ReferenceMode::Rebased),
        1 => Ok(ReferenceMode::Absolute),
        _ => Err(FiError::InvalidSetting),
    }
}

impl TryFrom<&FiSettings> for ControllerSettings {
    type Error = FiError;

    fn try_from(s: &FiSettings) -> Result<Self, FiError> {
        let discretisation = match s.discretisation {
            0 => Discretisation::ExactHold,
            1 => Discretisation::Bilinear,
            _ => return Err(FiError::InvalidSetting),
        };
        Ok(Self {
            interval_s: s.interval_s,
            discretisation,
            mode: mode(s.mode)?,
            max_error_n: s.max_error_n,
            max_reference_n: s.max_reference_n,
            reference_rate_n_per_s: s.reference_rate_n_per_s,
            reference_acceleration_n_per_s2: s.reference_acceleration_n_per_s2,
            reference_jerk_n_per_s3: s.reference_jerk_n_per_s3,
            travel_mm: s.travel_mm,
            rate_mm_per_s: s.rate_mm_per_s,
            acceleration_mm_per_s2: s.acceleration_mm_per_s2,
            jerk_mm_per_s3: s.jerk_mm_per_s3,
            approach_mm_per_s: s.approach_mm_per_s,
            contact_n: s.contact_n,
            max_cell_n: s.max_cell_n,
            max_friction_ratio: s.max_friction_ratio,
            max_disagreement_n: s.max_disagreement_n,
            max_blind_mm: s.max_blind_mm,
            max_consistency_mm: s.max_consistency_mm,
            max_normal_rad: s.max_normal_rad,
            frozen_cycles: s.frozen_cycles,
            suspect_cycles: s.suspect_cycles,
            hold_cycles: s.hold_cycles,
            recovery_cycles: s.recovery_cycles,
        })
    }
}

impl From<&ControllerSettings> for FiSettings {
    fn from(s: &ControllerSettings) -> Self {
        Self {
            interval_s: s.interval_s,
            max_error_n: s.max_error_n,
            max_reference_n: s.max_reference_n,
            reference_rate_n_per_s: s.reference_rate_n_per_s,
            reference_acceleration_n_per_s2: s.reference_acceleration_n_per_s2,
            reference_jerk_n_per_s3: s.reference_jerk_n_per_s3,
            travel_mm: s.travel_mm,
            rate_mm_per_s: s.rate_mm_per_s,
            acceleration_mm_per_s2: s.acceleration_mm_per_s2,
            jerk_mm_per_s3: s.jerk_mm_per_s3,
            approach_mm_per_s: s.approach_mm_per_s,
            contact_n: s.contact_n,
            max_cell_n: s.max_cell_n,
            max_friction_ratio: s.max_friction_ratio,
            max_disagreement_n: s.max_disagreement_n,
            max_blind_mm: s.max_blind_mm,
            max_consistency_mm: s.max_consistency_mm,
            max_normal_rad: s.max_normal_rad,
            frozen_cycles: s.frozen_cycles,
            suspect_cycles: s.suspect_cycles,
            hold_cycles: s.hold_cycles,
            recovery_cycles: s.recovery_cycles,
            discretisation: match s.discretisation {
                Discretisation::ExactHold => FiDiscretisation::ExactHold as u32,
                Discretisation::Bilinear => FiDiscretisation::Bilinear as u32,
            },
            mode: match s.mode {
                ReferenceMode::Rebased => FiMode::Rebased as u32,
                ReferenceMode::Absolute => FiMode::Absolute as u32,
            },
        }
    }
}

/// Settings of a head that presses up to 200 N at 1 kHz.
///
/// # Safety
///
/// The pointer is null or points at a live object.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fi_settings_default(settings: *mut FiSettings) -> FiError {
    // SAFETY: the caller's promise.
    code(unsafe { Output::at(settings) }.map(|at| at.put((&ControllerSettings::default()).into())))
}
