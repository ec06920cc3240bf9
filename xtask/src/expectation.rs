//! What is known of a case beforehand, recorded beside it in `provenance.toml`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Where a case comes from, and what solving it must give.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Provenance {
    /// One line for tables.
    pub title: String,
    /// Document and table, or the generator.
    pub source: String,
    /// Seed of a generated case.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Units of the tables.
    pub units: String,
    /// Terms under which the data may be used.
    pub licence: String,
    /// What is known to be true of the data.
    pub truth: String,
    /// What the source itself prints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub published: Option<String>,
    /// What measured data are asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub question: Option<String>,
    /// What a calculation of another hand made of the same data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub independent: Option<String>,
    /// What stays open.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub open: Option<String>,
    /// What was converted and left out on the way from the published files.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub converted: Vec<String>,
    /// Another case, `<crate>/<case>`, whose effects count as declared in this one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub carry: Option<String>,
    /// What must come out.
    pub expect: Expectation,
    /// SHA-256 of every other file of the folder.
    pub files: BTreeMap<String, String>,
}

/// What `truing` must say of a case.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Expectation {
    /// Any of these verdicts; empty where the case is only solved.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub verdict: Vec<String>,
    /// For each class, one added effect that is in it or cannot be told from one in it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<Vec<String>>,
    /// Whether effects of the catalogue beyond `effects` are a mismatch.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub nothing_else: bool,
    /// Whether a shape along a covariate may be added beside, as empirical, or an effect that the
    /// answer itself calls a rival of such a shape.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub empirical_allowed: bool,
    /// For each list, one covariate that must be named, as left-over or as empirical.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub structure: Vec<Vec<String>>,
    /// Effects that must be called not observable.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub not_observable: Vec<String>,
    /// Phrases that must stand somewhere in the answer.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub says: Vec<String>,
    /// Largest error on unseen data in the end over what the noise alone gives, and the latter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_out: Option<HeldOut>,
    /// Numbers of `truing loop --json`.
    #[serde(rename = "loop", skip_serializing_if = "Vec::is_empty")]
    pub loop_numbers: Vec<Number>,
    /// Numbers of `truing solve --json`.
    #[serde(rename = "solve", skip_serializing_if = "Vec::is_empty")]
    pub solve_numbers: Vec<Number>,
}

/// Bound of the error on data that was never seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct HeldOut {
    /// Root mean square per observation of the noise alone.
    pub noise: f64,
    /// Largest ratio to it.
    pub at_most: f64,
}

/// One number and how near it must be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Number {
    /// Keys from the root, separated by dots; `name=value` picks from a list.
    pub path: String,
    /// Expected value.
    pub value: f64,
    /// Largest deviation.
    pub tolerance: f64,
    /// Where the tolerance comes from.
    pub because: String,
}
