//! What a page is made from: plain data, nothing read from files.

use model_discrepancy::{Closure, Covariate, Layout};
use serde::{Deserialize, Serialize};

use super::budget::Budget;
use super::error_rms::Rms;
use super::fact::Fact;
use super::form::Form;

/// Everything that one page shows.
#[derive(Clone, Debug)]
pub struct ReportInput<'a> {
    /// Name of the case.
    pub title: &'a str,
    /// Kind of the case, e.g. `frame-fit`.
    pub kind: &'a str,
    /// Where the data come from: document and table, instrument, or generator and seed.
    pub source: Option<&'a str>,
    /// What is wrong with the input; everything else on the page is of the input as corrected.
    pub mistakes: &'a [Mistake],
    /// Error of the declared model on the input as it is, where that is wrong and can be fitted.
    pub as_read: Option<Rms>,
    /// What was measured and why, one paragraph per line.
    pub description: &'a [String],
    /// Facts about the measurement worth a table; counts of the layout are added by the page.
    pub measured: &'a [Fact],
    /// The declared model in words and formulas, one paragraph per line.
    pub declared: &'a [String],
    /// What was solved.
    pub parameters: &'a [ParameterRow],
    /// Rows, observations and groups of the residual.
    pub layout: &'a Layout,
    /// Names of the components of an observation, e.g. `x`, `y`, `z`; empty where there is one.
    pub components: &'a [String],
    /// What the residual is, e.g. `to − T(from)`.
    pub residual: &'a str,
    /// What one group is called, in the singular: `point`, `press`.
    pub group_noun: &'a str,
    /// What was found.
    pub evidence: Evidence<'a>,
    /// Quantities recorded beside the observations.
    pub covariates: &'a [Covariate],
    /// Pictures that only this kind of case has.
    pub plots: &'a [ExtraPlot],
    /// The form of the test that the case is, where it is one.
    pub form: Option<&'a Form>,
    /// Where the uncertainties come from, where the data were drawn anew.
    pub budget: Option<&'a Budget>,
    /// Figure printed in the source, to compare with.
    pub published: Option<&'a Published>,
    /// What is asked of the data, and known of them from elsewhere.
    pub story: Option<&'a Story>,
    /// Whether the data come from a simulation.
    pub simulated: bool,
    /// Notes the user should read, beside those of the closure.
    pub warnings: &'a [String],
}

/// What the page reports on.
#[derive(Clone, Copy, Debug)]
pub enum Evidence<'a> {
    /// A solve of the declared model: its residual, one per row of the layout.
    Solved {
        /// Residual per row, in the layout's unit.
        residuals: &'a [f64],
    },
    /// A closed loop.
    Closed(&'a Closure),
}

/// A mistake in the input.
#[derive(Clone, Debug, PartialEq)]
pub struct Mistake {
    /// Its name, and those that explain the data as well.
    pub names: Vec<String>,
    /// File and column.
    pub subject: String,
    /// What to change.
    pub description: String,
}

/// One solved parameter, in the unit it is reported in.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterRow {
    /// Name.
    pub name: String,
    /// Unit; empty for a pure number.
    pub unit: String,
    /// Estimate of the declared model.
    pub value: f64,
    /// Standard uncertainty of `value`, where there is redundancy.
    pub std: Option<f64>,
    /// Estimate and standard uncertainty with the accepted effects in the model.
    pub after: Option<(f64, f64)>,
}

/// What the owner of measured data asks of them, and knows from elsewhere.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Story {
    /// What the data are asked.
    pub question: Option<String>,
    /// What a calculation of another hand made of the same data.
    pub independent: Option<String>,
    /// What stays open.
    pub open: Option<String>,
}

/// A figure printed in the source of the data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Published {
    /// The figure as printed, with its unit.
    pub text: String,
    /// Where it is printed: document and table.
    pub source: String,
    /// Error that the source reports for its own model, in the layout's unit.
    pub rms: Option<f64>,
}

/// A picture that one kind of case adds.
#[derive(Clone, Debug, PartialEq)]
pub enum ExtraPlot {
    /// Error vectors at their places, before and after on one scale.
    Vectors(VectorMap),
    /// Deviations from a surface at their places, before and after on one scale.
    Deviations(DeviationMap),
    /// Curves and points over one quantity, with 95 % bands where given.
    Curves(CurvePlot),
}

/// Error vectors in a plane.
#[derive(Clone, Debug, PartialEq)]
pub struct VectorMap {
    /// Heading.
    pub title: String,
    /// One sentence on what to look for.
    pub caption: String,
    /// Title of the horizontal axis with its unit.
    pub x_title: String,
    /// Title of the vertical axis with its unit.
    pub y_title: String,
    /// Unit of the vectors.
    pub unit: String,
    /// A surface under the vectors, the farthest facet first; empty where there is none.
    pub facets: Vec<Facet>,
    /// Vectors of the declared model.
    pub before: Vec<Arrow>,
    /// Vectors with the accepted effects; empty where nothing was added.
    pub after: Vec<Arrow>,
}

/// A piece of a surface as it is seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Facet {
    /// Its corners, one after the other.
    pub corners: [[f64; 2]; 4],
    /// From 0, in full light, to 1.
    pub shade: f64,
}

/// One error vector, `[x, y]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Arrow {
    /// Where it starts.
    pub at: [f64; 2],
    /// The error.
    pub error: [f64; 2],
    /// Name of the point.
    pub name: String,
}

/// Deviations from a surface seen along an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviationMap {
    /// Heading.
    pub title: String,
    /// One sentence on what to look for.
    pub caption: String,
    /// Title of the horizontal axis with its unit.
    pub x_title: String,
    /// Title of the vertical axis with its unit.
    pub y_title: String,
    /// Unit of the deviations.
    pub unit: String,
    /// Where each point is.
    pub at: Vec<[f64; 2]>,
    /// Name of each point.
    pub names: Vec<String>,
    /// Deviations with the declared model, one per point; NaN where there is none.
    pub before: Vec<f64>,
    /// Deviations with the accepted effects; empty where nothing was added.
    pub after: Vec<f64>,
}

/// Curves over one quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct CurvePlot {
    /// Heading.
    pub title: String,
    /// One sentence on what to look for.
    pub caption: String,
    /// Title of the horizontal axis with its unit.
    pub x_title: String,
    /// Title of the vertical axis with its unit.
    pub y_title: String,
    /// What is drawn; at most six are told apart by colour.
    pub curves: Vec<Curve>,
}

/// One curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Points `[x, y]`, ascending in x where joined.
    pub points: Vec<[f64; 2]>,
    /// Half-width of the 95 % band, one per point; empty for none.
    pub half_widths: Vec<f64>,
    /// Whether the points are joined by a line; otherwise they are drawn as marks.
    pub joined: bool,
}
