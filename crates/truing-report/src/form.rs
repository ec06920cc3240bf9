//! What a customer asks for of a test: who measured what, the results by their names, and whether
//! they are within their limits.

use super::fact::Fact;

/// What a limit's name has after the symbol of a result with the named effects taken off.
pub const COMPENSATED: &str = ", effects taken off";

/// The form of a test, e.g. of a positioning by ISO 230-2.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Form {
    /// What was tested, and by which standard.
    pub title: String,
    /// Who, when, with what, at which temperatures: `None` of what is not declared.
    pub header: Vec<(String, Option<String>)>,
    /// How the test was made.
    pub conditions: Vec<Fact>,
    /// The results, in the order of the standard.
    pub results: Vec<FormResult>,
    /// What would be left of them if every effect that was named were compensated; a limit names
    /// such a one by its symbol with [`COMPENSATED`].
    pub compensated: Vec<FormResult>,
    /// What the results are and what is not in their uncertainty, one paragraph a line.
    pub notes: Vec<String>,
    /// The decision rule, where results have limits.
    pub rule: Option<String>,
}

/// One result of a form.
#[derive(Clone, Debug, PartialEq)]
pub struct FormResult {
    /// Its symbol: `A`, `EXC`.
    pub symbol: String,
    /// What it is.
    pub name: String,
    /// Its unit; empty for a pure number.
    pub unit: String,
    /// Its value; `None` where the data do not give it.
    pub value: Option<f64>,
    /// Standard uncertainty.
    pub std: Option<f64>,
    /// What it is held against.
    pub limit: Option<FormLimit>,
}

/// A limit of a result, and what is decided.
#[derive(Clone, Debug, PartialEq)]
pub struct FormLimit {
    /// Largest magnitude allowed, in the unit of the result.
    pub limit: f64,
    /// Probability that the true value is within it; `None` without an uncertainty.
    pub probability: Option<f64>,
    /// `pass`, `fail` or `undecided`.
    pub decision: &'static str,
}
