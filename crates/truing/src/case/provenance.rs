use std::collections::BTreeMap;

use serde::de::Deserializer;
use serde::{Deserialize, Serialize};
use truing_report::Story;

use super::folder::Folder;

/// Name of the file; a case need not have it.
const PROVENANCE_FILE: &str = "provenance.toml";

/// Where the data come from, for reports and answers to say; further keys are the owner's own.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Provenance {
    /// One line for the head of the report.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// Document and table, instrument, or generator and seed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// What the source prints, to compare with.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub published: Option<String>,
    /// The machine measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub machine: Option<String>,
    /// The instrument that measured it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub instrument: Option<String>,
    /// Who measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub operator: Option<String>,
    /// When, as it is written.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "date")]
    pub date: Option<String>,
    /// Temperatures during the measurement, °C, by place.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub temperatures: BTreeMap<String, f64>,
    /// What the data are asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub question: Option<String>,
    /// What a calculation of another hand made of the same data.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub independent: Option<String>,
    /// What stays open.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub open: Option<String>,
    /// Seed of a simulation.
    #[serde(skip_serializing)]
    seed: Option<toml::Value>,
}

/// A date of TOML's own, or a text.
fn date<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<String>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Date {
        Date(toml::value::Datetime),
        Text(String),
    }
    Ok(Some(match Date::deserialize(deserializer)? {
        Date::Date(date) => date.to_string(),
        Date::Text(text) => text,
    }))
}

impl Provenance {
    /// What is asked, and known from elsewhere, where anything is.
    pub(crate) fn story(&self) -> Option<Story> {
        let Self { question, independent, open, .. } = self.clone();
        let story = Story { question, independent, open };
        (story != Story::default()).then_some(story)
    }

    /// A seed is written beside simulated data alone.
    pub(crate) fn is_simulated(&self) -> bool {
        self.seed.is_some()
    }

    /// What the folder says; a file that cannot be read is no reason not to solve.
    pub(crate) fn read(folder: &Folder, warnings: &mut Vec<String>) -> Option<Self> {
        if !folder.has(PROVENANCE_FILE) {
            return None;
        }
        let parsed = match folder.text(PROVENANCE_FILE) {
            Ok(text) => toml::from_str(&text).map_err(|e| e.message().to_owned()),
            Err(e) => Err(e.to_string()),
        };
        let parsed = parsed.and_then(|provenance: Self| {
            match provenance.temperatures.iter().find(|(_, value)| !value.is_finite()) {
                Some((place, _)) => Err(format!("the temperature `{place}` is no number")),
                None => Ok(provenance),
            }
        });
        parsed
            .map_err(|message| warnings.push(format!("{PROVENANCE_FILE} is left aside: {message}")))
            .ok()
    }
}
