//! Estimated numbers, and the formats in which tables of them are exported.

use model_discrepancy::ParameterEstimate;
use serde::Serialize;

/// A table that other programs read.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Export {
    /// Comma-separated values with the names of ISO 230.
    Csv,
    /// A compensation file of LinuxCNC, `COMP_FILE_TYPE = 0`.
    LinuxCnc,
    /// A plain table in the layout of Heidenhain's, which no control imports.
    Heidenhain,
    /// What the errors of a rotary axis do to a point of the frame that turns with it, mm, angle by angle.
    PointErrors([f64; 3]),
}

/// One estimated number, in the unit it is reported in.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimated {
    /// Name.
    pub name: String,
    /// Unit; empty for a pure number.
    pub unit: &'static str,
    /// Estimate.
    pub value: f64,
    /// Standard uncertainty, where there is redundancy.
    pub std: Option<f64>,
}

impl Estimated {
    pub(crate) fn new(name: &str, unit: &'static str, value: f64, std: Option<f64>) -> Self {
        Self { name: name.to_owned(), unit, value, std }
    }
}

/// One amplitude.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoopParameter {
    /// Name.
    pub name: String,
    /// Estimate.
    pub value: f64,
    /// Unit.
    pub unit: String,
    /// Standard uncertainty.
    pub std: f64,
}

impl LoopParameter {
    pub(crate) fn of(parameter: &ParameterEstimate) -> Self {
        Self {
            name: parameter.name.clone(),
            value: parameter.value,
            unit: parameter.unit.clone(),
            std: parameter.std,
        }
    }
}
