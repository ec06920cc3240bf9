//! `cargo xtask repro`: every committed case through `truing`, beside what is known of it.

mod judge;
mod table;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::expectation::Provenance;
use crate::program::{Answer, Truing};
use crate::schema::Schemas;
use crate::shell;

/// A committed case and what `truing` made of it.
pub(crate) struct Outcome {
    /// Crate and case.
    pub(crate) name: String,
    pub(crate) provenance: Provenance,
    /// Answer of `truing loop --json`.
    pub(crate) loop_json: Value,
    /// What is not as it should be; empty when all is well.
    pub(crate) mismatches: Vec<String>,
}

/// Runs all cases and fails if any is not as recorded.
pub(crate) fn run() -> Result<()> {
    let truing = Truing::build()?;
    let reports = shell::root().join("target/repro");
    fs::create_dir_all(&reports).context("cannot make target/repro")?;
    let schemas = Schemas::read()?;
    let mut outcomes = Vec::new();
    for folder in case_folders()? {
        outcomes.push(outcome(&truing, &schemas, &folder, &reports)?);
    }
    table::print(&outcomes);
    index(&truing, &outcomes, &reports)?;
    let wrong = outcomes.iter().filter(|o| !o.mismatches.is_empty()).count();
    if wrong > 0 {
        bail!("{wrong} of {} cases are not as recorded beside them", outcomes.len());
    }
    Ok(())
}

/// Folders `fixtures/<crate>/<case>` that `truing` can read, sorted.
fn case_folders() -> Result<Vec<PathBuf>> {
    let mut folders = Vec::new();
    for file in shell::source_files()? {
        if file.starts_with("fixtures/") && file.ends_with("/case.toml") {
            folders.push(PathBuf::from(file.trim_end_matches("/case.toml")));
        }
    }
    if folders.is_empty() {
        bail!("no case under fixtures/; `cargo xtask fixtures` writes them");
    }
    Ok(folders)
}

fn outcome(truing: &Truing, schemas: &Schemas, folder: &Path, reports: &Path) -> Result<Outcome> {
    let parts: Vec<String> =
        folder.iter().skip(1).map(|part| part.to_string_lossy().into_owned()).collect();
    let in_root = shell::root().join(folder);
    let text = fs::read_to_string(in_root.join("provenance.toml"))
        .with_context(|| format!("{} has no provenance.toml", folder.display()))?;
    let provenance: Provenance =
        toml::from_str(&text).with_context(|| format!("{}/provenance.toml", folder.display()))?;

    let page = reports.join(format!("{}.html", parts.join("-")));
    let case = in_root.to_string_lossy().into_owned();
    let report = page.to_string_lossy().into_owned();
    let closed = truing.run(&["loop", &case, "--json", "--report", &report])?;
    let solved = truing.run(&["solve", &case, "--json"])?;
    let checked = truing.run(&["check", &case, "--json"])?;
    let answers = [("loop", &closed), ("solve", &solved), ("check", &checked)];
    let mut mismatches = failures(&answers);
    if mismatches.is_empty() {
        mismatches = judge::mismatches(&provenance.expect, &closed.json, &solved.json);
        for (command, answer) in answers {
            let wrong = schemas.mismatches(&answer.json)?;
            mismatches.extend(wrong.into_iter().map(|w| format!("schema of {command}: {w}")));
        }
    }
    Ok(Outcome { name: parts.join("/"), provenance, loop_json: closed.json, mismatches })
}

fn failures(answers: &[(&str, &Answer)]) -> Vec<String> {
    answers
        .iter()
        .filter(|(_, answer)| answer.code != Some(0))
        .map(|(command, answer)| {
            let code = answer.code.map_or("a signal".to_owned(), |code| format!("code {code}"));
            format!("truing {command} ended with {code}: {}", answer.message)
        })
        .collect()
}

/// One page over all cases.
fn index(truing: &Truing, outcomes: &[Outcome], reports: &Path) -> Result<()> {
    let index = reports.join("report.html").to_string_lossy().into_owned();
    let mut arguments = vec!["index".to_owned(), "--output".to_owned(), index];
    for outcome in outcomes {
        let page = reports.join(format!("{}.html", outcome.name.replace('/', "-")));
        if page.is_file() {
            arguments.push(page.to_string_lossy().into_owned());
        }
    }
    let answer = truing.run(&arguments)?;
    if answer.code != Some(0) {
        bail!("no index of the reports: {}", answer.message);
    }
    println!("report: target/repro/report.html");
    Ok(())
}
