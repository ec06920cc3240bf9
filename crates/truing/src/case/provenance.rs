use serde::Deserialize;

use super::folder::Folder;

/// Name of the file; a case need not have it.
const PROVENANCE_FILE: &str = "provenance.toml";

/// Where the data come from, for the report alone; other keys are the owner's own.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Provenance {
    /// One line for the head of the report.
    pub(crate) title: Option<String>,
    /// Document and table, instrument, or generator and seed.
    pub(crate) source: Option<String>,
    /// What the source prints, to compare with.
    pub(crate) published: Option<String>,
}

impl Provenance {
    /// What the folder says; a file that cannot be read is no reason not to solve.
    pub(crate) fn read(folder: &Folder, warnings: &mut Vec<String>) -> Self {
        if !folder.has(PROVENANCE_FILE) {
            return Self::default();
        }
        let parsed = match folder.text(PROVENANCE_FILE) {
            Ok(text) => toml::from_str(&text).map_err(|e| e.message().to_owned()),
            Err(e) => Err(e.to_string()),
        };
        parsed.unwrap_or_else(|message: String| {
            warnings.push(format!("{PROVENANCE_FILE} is left aside: {message}"));
            Self::default()
        })
    }
}
