use serde::Serialize;
use truing_report::{ExtraPlot, Form};

use super::axis_run::AxisRunEstimate;
use super::figures::PositioningFigures;
use super::form::positioning_form;
use crate::estimated::{Estimated, Export};
use crate::estimates::Estimates;
use crate::implausible::ImplausibleResult;
use crate::text_table::TextTable;

/// What a `positioning` case is solved for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PositioningEstimates {
    /// Figures and compensation table.
    pub run: AxisRunEstimate,
    /// The same by name, and what the control is to add.
    pub positioning: PositioningFigures,
    /// Where the accepted effects are.
    pub conditions: Vec<String>,
    /// One per row.
    pub readings: Vec<PositionResidual>,
}

/// One reading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PositionResidual {
    /// Name of the row.
    pub point: String,
    /// The target.
    pub target: f64,
    /// Actual less target.
    pub deviation: f64,
    /// What the accepted effects add to the deviation.
    pub correction: f64,
    /// Deviation less correction.
    pub residual: f64,
}

impl Estimates for PositioningEstimates {
    fn parameters(&self) -> Vec<Estimated> {
        self.run.parameters()
    }

    fn tables(&self) -> Vec<TextTable> {
        vec![self.run.table()]
    }

    fn conditions(&self) -> &[String] {
        &self.conditions
    }

    fn plots(&self) -> Vec<ExtraPlot> {
        vec![self.run.plot()]
    }

    fn form(&self) -> Option<Form> {
        Some(positioning_form(&self.run))
    }

    fn export(&self, format: Export) -> Option<String> {
        self.run.export(format)
    }

    fn implausible(&self, _: Option<f64>) -> Option<ImplausibleResult> {
        self.run.implausible()
    }
}
