use serde::Serialize;

use crate::Header;
use crate::kinds::PoseNumbers;

/// Answer of `truing itlicp`; serialises as its JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Itlicp {
    /// Kind of the case.
    pub kind: &'static str,
    /// Version of this crate.
    pub version: &'static str,
    /// Form, program, inputs and provenance.
    #[serde(flatten)]
    pub header: Header,
    /// Δw, spacing of the first level; `None` of the classical method.
    pub coarse_mm: Option<f64>,
    /// Δw1, spacing of the last level.
    pub fine_mm: Option<f64>,
    /// `δ_set`: it ends when every touch is nearer to a model point.
    pub tolerance_mm: f64,
    /// One per level.
    pub levels: Vec<ItlicpLevel>,
    /// What it finds.
    pub itlicp: PoseBeside,
    /// The exact pose, from the same start.
    pub exact: PoseBeside,
    /// What both leave of every point, in the order of the table.
    pub points: Vec<ItlicpPoint>,
    /// How long both took; `None` leaves it out of the JSON.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub timing: Option<ItlicpTiming>,
    /// Notes the user should read.
    pub warnings: Vec<String>,
}

/// One level of the method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ItlicpLevel {
    /// Points of the model.
    pub model_points: usize,
    /// Searches and fits.
    pub iterations: usize,
}

/// A pose, workpiece to machine, and what it leaves of all points along the part's normal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PoseBeside {
    /// Position and angles.
    #[serde(flatten)]
    pub numbers: PoseNumbers,
    /// Root mean square.
    pub rms_mm: f64,
    /// The largest.
    pub largest_mm: f64,
}

/// What both poses leave of one point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ItlicpPoint {
    /// Its name.
    pub point: String,
    /// `fit` or `check`.
    #[serde(rename = "use")]
    pub usage: &'static str,
    /// Distance of the ball's centre from the part, less the ball's radius; `None` where it has no
    /// closest point.
    pub residual_mm: Option<f64>,
    /// The same at the exact pose.
    pub exact_residual_mm: Option<f64>,
}

/// Wall-clock times.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ItlicpTiming {
    /// Of ITLICP.
    pub itlicp_s: f64,
    /// Of the exact fit.
    pub exact_s: f64,
}
