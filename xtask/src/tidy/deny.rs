//! The lists of `xtask/deny.toml`, which `cargo deny` reads as well.

use std::fs;

use anyhow::{Context, Result};
use serde::Deserialize;

use crate::shell;

const FILE: &str = "xtask/deny.toml";

/// What dependencies are held to.
#[derive(Debug, Default, Deserialize)]
pub(super) struct Deny {
    licenses: Licences,
    bans: Bans,
}

#[derive(Debug, Default, Deserialize)]
struct Licences {
    allow: Vec<String>,
    exceptions: Vec<Exception>,
}

/// What only tests run may have a licence of its own.
#[derive(Debug, Deserialize)]
struct Exception {
    #[serde(rename = "crate")]
    name: String,
    allow: Vec<String>,
}

#[derive(Debug, Default, Deserialize)]
struct Bans {
    skip: Vec<Skip>,
}

/// A second version that is known of.
#[derive(Debug, Deserialize)]
struct Skip {
    /// `name@version`
    #[serde(rename = "crate")]
    name: String,
}

impl Deny {
    pub(super) fn read() -> Result<Self> {
        let text = fs::read_to_string(shell::root().join(FILE)).context(FILE)?;
        toml::from_str(&text).context(FILE)
    }

    pub(super) fn allows(&self, package: &str, licence: &str) -> bool {
        let exceptions = self.licenses.exceptions.iter().filter(|e| e.name == package);
        let mut allowed = self.licenses.allow.iter().chain(exceptions.flat_map(|e| &e.allow));
        allowed.any(|allowed| allowed == licence)
    }

    /// Whether only tests may use it.
    pub(super) fn is_tool(&self, package: &str) -> bool {
        self.licenses.exceptions.iter().any(|e| e.name == package)
    }

    /// Whether this version is known to come beside a newer one; what follows `+` in it says nothing.
    pub(super) fn skips(&self, package: &str, version: &str) -> bool {
        let version = version.split('+').next().unwrap_or(version);
        self.bans.skip.iter().any(|skip| skip.name == format!("{package}@{version}"))
    }

    #[cfg(test)]
    pub(super) fn with(mut self, licence: &str) -> Self {
        self.licenses.allow.push(licence.to_owned());
        self
    }
}
