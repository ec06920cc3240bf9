//! What a table of displacements is solved for.

use serde::Serialize;
use truing_report::{ExtraPlot, Form};

use super::{CenterEstimate, FrameEstimate};
use crate::estimated::{Estimated, Export};
use crate::estimates::Estimates;
use crate::implausible::ImplausibleResult;
use crate::kinds::positioning::positioning_form;
use crate::kinds::{AxisRunEstimate, PositioningFigures};
use crate::text_table::TextTable;

/// What a table of displacements is solved for: nothing but its own residual.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DisplacementEstimates {
    /// Always `None`: displacements do not place the sensor.
    pub frame: Option<FrameEstimate>,
    /// Always empty.
    pub centers: Vec<CenterEstimate>,
    /// Where the accepted effects are.
    pub conditions: Vec<String>,
    /// Figures by ISO 230-2 and compensation table, where targets repeat or were approached both
    /// ways; `None` elsewhere.
    pub run: Option<AxisRunEstimate>,
    /// The same by name, and what the control is to add.
    pub positioning: Option<PositioningFigures>,
    /// One per row.
    pub points: Vec<DisplacementResidual>,
}

/// One row of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DisplacementResidual {
    /// Name of the row.
    pub point: String,
    /// How far the machine moved.
    pub commanded_mm: f64,
    /// How far the sensor found it to have moved.
    pub solved_mm: f64,
    /// What the accepted effects add to `solved_mm`.
    pub correction_mm: f64,
    /// `solved − correction`: the displacement with the accepted effects taken off.
    pub corrected_mm: f64,
    /// `corrected − commanded`.
    pub residual_mm: f64,
}

impl Estimates for DisplacementEstimates {
    fn parameters(&self) -> Vec<Estimated> {
        self.run.iter().flat_map(AxisRunEstimate::parameters).collect()
    }

    fn tables(&self) -> Vec<TextTable> {
        let columns = ["point", "commanded mm", "solved mm", "corrected mm", "residual mm"];
        let mut table = TextTable::new("displacements", &columns);
        for p in &self.points {
            let name = p.point.clone().into();
            let numbers =
                [p.commanded_mm, p.solved_mm, p.corrected_mm, p.residual_mm].map(Into::into);
            table.push([name].into_iter().chain(numbers).collect());
        }
        self.run.iter().map(AxisRunEstimate::table).chain([table]).collect()
    }

    fn conditions(&self) -> &[String] {
        &self.conditions
    }

    fn plots(&self) -> Vec<ExtraPlot> {
        self.run.iter().map(AxisRunEstimate::plot).collect()
    }

    fn form(&self) -> Option<Form> {
        self.run.as_ref().map(positioning_form)
    }

    fn export(&self, format: Export) -> Option<String> {
        self.run.as_ref()?.export(format)
    }

    fn implausible(&self, _: Option<f64>) -> Option<ImplausibleResult> {
        self.run.as_ref()?.implausible()
    }
}
