//! The oldest compiler that manifests declare is the one that everything is tested with.

use std::fs;

use anyhow::{Context, Result};
use serde_json::Value;

use super::Finding;
use crate::shell;

/// Compares `rust-version` of every member with `rust-toolchain.toml`.
pub(super) fn check(metadata: &Value) -> Result<Vec<Finding>> {
    let file = "rust-toolchain.toml";
    let text = fs::read_to_string(shell::root().join(file)).context(file)?;
    let toolchain: toml::Table = toml::from_str(&text).context(file)?;
    let tested = toolchain["toolchain"]["channel"].as_str().unwrap_or_default();
    let packages = metadata["packages"].as_array().map_or(&[][..], Vec::as_slice);
    let members = packages.iter().filter(|package| package["source"].is_null());
    Ok(members.filter_map(|package| untested(package, tested)).collect())
}

fn untested(package: &Value, tested: &str) -> Option<Finding> {
    let declared = package["rust_version"].as_str()?;
    let is_tested = tested == declared || tested.starts_with(&format!("{declared}."));
    let text = format!("{} declares Rust {declared}; tests run with {tested}", package["name"]);
    (!is_tested).then(|| Finding::error(text))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::untested;

    #[test]
    fn another_compiler_than_the_tested_one_is_found() {
        let declares = |version: &str| json!({ "name": "x", "rust_version": version });
        assert!(untested(&declares("1.95"), "1.95.0").is_none());
        assert!(untested(&declares("1.95.0"), "1.95.0").is_none());
        assert!(untested(&declares("1.9"), "1.95.0").is_some());
        assert!(untested(&declares("1.94"), "1.95.0").is_some());
    }
}
