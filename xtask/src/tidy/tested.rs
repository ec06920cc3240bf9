//! Libraries that are built without a test program of their own have no tests in it, and what is
//! declared for tests is used by them.

use anyhow::Result;
use serde_json::Value;

use super::Finding;
use super::source::is_rust;
use crate::shell;

/// Checks the sources of every member.
pub(super) fn check(metadata: &Value, files: &[String]) -> Result<Vec<Finding>> {
    let mut findings = never_run(metadata, files)?;
    findings.extend(unused(metadata, files)?);
    Ok(findings)
}

/// Dependencies for tests that no source of the crate names.
fn unused(metadata: &Value, files: &[String]) -> Result<Vec<Finding>> {
    let packages = metadata["packages"].as_array().map_or(&[][..], Vec::as_slice);
    let mut findings = Vec::new();
    for package in packages.iter().filter(|package| package["source"].is_null()) {
        let text = sources(package, files)?;
        let dependencies = package["dependencies"].as_array().map_or(&[][..], Vec::as_slice);
        let for_tests = dependencies.iter().filter(|dependency| dependency["kind"] == "dev");
        for dependency in for_tests {
            let name = dependency["rename"].as_str().or(dependency["name"].as_str());
            let name = name.unwrap_or_default();
            if !text.contains(&name.replace('-', "_")) {
                let text = format!("{} declares {name} and no test uses it", package["name"]);
                findings.push(Finding::error(text));
            }
        }
    }
    Ok(findings)
}

/// All sources of a member, one after the other.
fn sources(package: &Value, files: &[String]) -> Result<String> {
    let root = shell::root().to_string_lossy().into_owned();
    let manifest = package["manifest_path"].as_str().unwrap_or_default();
    let folder = manifest.trim_start_matches(&root).trim_start_matches('/');
    let folder = folder.trim_end_matches("Cargo.toml");
    let mut text = String::new();
    for file in files.iter().filter(|f| f.starts_with(folder) && is_rust(f)) {
        text += &std::fs::read_to_string(shell::root().join(file))?;
    }
    Ok(text)
}

/// Tests in sources of members whose library says `test = false`.
fn never_run(metadata: &Value, files: &[String]) -> Result<Vec<Finding>> {
    let root = shell::root().to_string_lossy().into_owned();
    let packages = metadata["packages"].as_array().map_or(&[][..], Vec::as_slice);
    let members = packages.iter().filter(|package| package["source"].is_null());
    let targets = members.filter_map(|package| package["targets"].as_array()).flatten();
    let mut findings = Vec::new();
    for target in targets.filter(|t| t["test"] == false && t["doctest"] == true) {
        let main = target["src_path"].as_str().unwrap_or_default();
        let folder = main.trim_start_matches(&root).trim_start_matches('/');
        let folder = folder.trim_end_matches("lib.rs");
        let sources = files.iter().filter(|f| f.starts_with(folder) && is_rust(f));
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
