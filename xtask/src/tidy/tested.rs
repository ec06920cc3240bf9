//! Libraries that are built without a test program of their own have no tests in it.

use std::path::Path;

use anyhow::Result;
use serde_json::Value;

use super::Finding;
use crate::shell;

/// Checks the sources of every member whose library says `test = false`.
pub(super) fn check(metadata: &Value, files: &[String]) -> Result<Vec<Finding>> {
    let root = shell::root().to_string_lossy().into_owned();
    let packages = metadata["packages"].as_array().map_or(&[][..], Vec::as_slice);
    let members = packages.iter().filter(|package| package["source"].is_null());
    let targets = members.filter_map(|package| package["targets"].as_array()).flatten();
    let mut findings = Vec::new();
    for target in targets.filter(|t| t["test"] == false && t["doctest"] == true) {
        let main = target["src_path"].as_str().unwrap_or_default();
        let folder = main.trim_start_matches(&root).trim_start_matches('/');
        let folder = folder.trim_end_matches("lib.rs");
        let is_source = |f: &&String| Path::new(f).extension() == Some("rs".as_ref());
        let sources = files.iter().filter(|f| f.starts_with(folder)).filter(is_source);
        for file in sources {
            if std::fs::read_to_string(shell::root().join(file))?.contains("#[test]") {
                let text =
                    format!("{file} has tests that never run: its library says `test = false`");
                findings.push(Finding::error(text));
            }
        }
    }
    Ok(findings)
}
