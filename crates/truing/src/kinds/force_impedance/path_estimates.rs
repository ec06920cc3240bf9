//! What runs along a path are solved for.

use serde::Serialize;

use super::estimates::ContactForceEstimate;
use crate::estimated::Estimated;
use crate::estimates::Estimates;
use crate::implausible::ImplausibleResult;
use crate::text_table::TextTable;

/// What runs along a path are solved for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PathForceEstimates {
    /// Force read against force asked for, over all readings on the common stretch.
    pub contact_force: ContactForceEstimate,
    /// Readings on the stretch that every run went over.
    pub samples: usize,
    /// Readings outside of it, which are left out.
    pub samples_left_out: usize,
    /// Runs.
    pub runs: usize,
    /// Mean error of all runs along the path.
    pub path: Vec<PathError>,
    /// Where the accepted effects are.
    pub conditions: Vec<String>,
    /// After the loop: every run in every cell of the path; else empty.
    pub cells: Vec<PathCell>,
}

/// One run in one cell of the path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PathCell {
    /// Name of the run.
    pub run: String,
    /// Mean place of its readings.
    pub path_mm: f64,
    /// Force read − force asked for, mean over its readings.
    pub error_n: f64,
    /// What the accepted effects add to the force.
    pub correction_n: f64,
    /// `error − correction`.
    pub residual_n: f64,
}

/// Mean error at one place of the path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PathError {
    /// Middle of the place.
    pub path_mm: f64,
    /// Force read − force asked for − correction, mean over the runs.
    pub error_n: f64,
    /// What the accepted effects add to the force here, mean over the runs.
    pub correction_n: f64,
}

impl Estimates for PathForceEstimates {
    fn parameters(&self) -> Vec<Estimated> {
        let force = &self.contact_force;
        let all = [
            ("force, rms error", force.rms_error_n),
            ("force, largest error", force.max_error_n),
            ("force, mean", Some(force.mean_n)),
            ("force, least", Some(force.min_n)),
            ("force, largest", Some(force.max_n)),
        ];
        all.into_iter()
            .filter_map(|(name, value)| Some(Estimated::new(name, "N", value?, None)))
            .collect()
    }

    fn tables(&self) -> Vec<TextTable> {
        let columns = ["path mm", "error N", "correction N"];
        let shown = if self.cells.is_empty() { 2 } else { 3 };
        let mut table = TextTable::new("mean error along the path", &columns[..shown]);
        for at in &self.path {
            let row = [at.path_mm, at.error_n, at.correction_n].map(Into::into);
            table.push(row.into_iter().take(shown).collect());
        }
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
