use serde::Serialize;

use crate::estimated::Estimated;
use crate::estimates::Estimates;
use crate::implausible::ImplausibleResult;
use crate::text_table::TextTable;

/// What a log of a polishing head is solved for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ForceImpedanceEstimates {
    /// Contact force from the legs against the reference.
    pub contact_force: ContactForceEstimate,
    /// Samples in the log.
    pub samples: usize,
    /// Mean ratio of friction to normal force, where something presses.
    pub friction_ratio: Option<f64>,
    /// Least internal force of the legs.
    pub preload_min_n: f64,
    /// Mean disagreement of the four lengths.
    pub consistency_mean_mm: f64,
    /// Root mean square of it.
    pub consistency_rms_mm: f64,
    /// The declared impedance at the log's sampling interval; `None` where none is declared.
    pub impedance: Option<ImpedanceEstimate>,
    /// Where the accepted effects are.
    pub conditions: Vec<String>,
    /// After the loop: means over the blocks of samples that it works on; else empty.
    pub blocks: Vec<ForceBlock>,
}

/// Mean over one block of samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ForceBlock {
    /// Number of its first sample in the log, from 0.
    pub first_sample: usize,
    /// How many samples it averages.
    pub samples: usize,
    /// Normal force as read from the legs.
    pub force_n: f64,
    /// What the accepted effects add to it.
    pub correction_n: f64,
    /// Legs − reference with the accepted effects taken off, those of the reference too; mm, and of
    /// the lengths, where there is no reference.
    pub residual: f64,
}

/// Contact force from the legs, along the normal, with the accepted effects taken off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ContactForceEstimate {
    /// Root mean square of legs − reference; `None` without a reference.
    pub rms_error_n: Option<f64>,
    /// Largest magnitude of it.
    pub max_error_n: Option<f64>,
    /// Mean force.
    pub mean_n: f64,
    /// Least force.
    pub min_n: f64,
    /// Largest force.
    pub max_n: f64,
}

/// What the declared impedance is, sampled as the log is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ImpedanceEstimate {
    /// Median sampling interval of the log.
    pub interval_s: f64,
    /// Time constant `M/D` of the speed.
    pub time_constant_s: f64,
    /// Natural frequency `√(K/M)/2π`; `None` without stiffness.
    pub natural_hz: Option<f64>,
    /// Damping ratio `D/2√(K M)`; `None` without stiffness.
    pub damping_ratio: Option<f64>,
}

impl Estimates for ForceImpedanceEstimates {
    fn parameters(&self) -> Vec<Estimated> {
        let force = &self.contact_force;
        let all = [
            ("contact force, rms error", "N", force.rms_error_n),
            ("contact force, largest error", "N", force.max_error_n),
            ("contact force, mean", "N", Some(force.mean_n)),
            ("contact force, least", "N", Some(force.min_n)),
            ("contact force, largest", "N", Some(force.max_n)),
            ("friction over normal force, mean", "", self.friction_ratio),
            ("preload of the legs, least", "N", Some(self.preload_min_n)),
            ("disagreement of the lengths, mean", "mm", Some(self.consistency_mean_mm)),
            ("disagreement of the lengths, rms", "mm", Some(self.consistency_rms_mm)),
            ("impedance, natural frequency", "Hz", self.impedance.and_then(|i| i.natural_hz)),
            ("impedance, damping ratio", "", self.impedance.and_then(|i| i.damping_ratio)),
        ];
        all.into_iter()
            .filter_map(|(name, unit, value)| Some(Estimated::new(name, unit, value?, None)))
            .collect()
    }

    fn tables(&self) -> Vec<TextTable> {
        let mut table = TextTable::new("log", &["samples"]);
        table.push(vec![self.samples.to_string().into()]);
        vec![table]
    }

    fn conditions(&self) -> &[String] {
        &self.conditions
    }

    fn implausible(&self, _: Option<f64>) -> Option<ImplausibleResult> {
        // A force may be any that the cell can read.
        None
    }
}
