//! Every fixture says where it comes from, and is what it says.

use std::collections::BTreeMap;
use std::fs;

use anyhow::{Context, Result};

use super::Finding;
use crate::expectation::Provenance;
use crate::generators::sha256;
use crate::shell;

/// Checks provenance and hashes of every folder that holds data.
pub(super) fn check(files: &[String]) -> Result<Vec<Finding>> {
    let mut folders: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for file in files.iter().filter(|file| file.starts_with("fixtures/")) {
        let (folder, name) = file.rsplit_once('/').unwrap_or(("", file));
        folders.entry(folder).or_default().push(name);
    }
    let mut findings = Vec::new();
    for (folder, names) in folders {
        if names.contains(&"case.toml") {
            findings.extend(case(folder, &names)?);
        } else if !names.iter().any(|name| name.starts_with("provenance.") || *name == "README.md")
        {
            findings.push(Finding::error(format!("{folder} does not say where it comes from")));
        }
    }
    Ok(findings)
}

fn case(folder: &str, names: &[&str]) -> Result<Vec<Finding>> {
    let in_root = shell::root().join(folder);
    let Ok(text) = fs::read_to_string(in_root.join("provenance.toml")) else {
        return Ok(vec![Finding::error(format!("{folder} has no provenance.toml"))]);
    };
    let provenance: Provenance = match toml::from_str(&text) {
        Ok(provenance) => provenance,
        Err(error) => {
            return Ok(vec![Finding::error(format!("{folder}/provenance.toml: {error}"))]);
        }
    };
    let mut findings = Vec::new();
    for &name in names.iter().filter(|&&name| name != "provenance.toml") {
        let bytes = fs::read(in_root.join(name)).with_context(|| format!("{folder}/{name}"))?;
        match provenance.files.get(name) {
            Some(hash) if *hash == sha256(&bytes) => {}
            Some(_) => findings.push(Finding::error(format!("{folder}/{name}: hash differs"))),
            None => findings.push(Finding::error(format!("{folder}/{name}: no hash"))),
        }
    }
    Ok(findings)
}
