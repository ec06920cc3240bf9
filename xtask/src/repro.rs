//! `cargo xtask repro`: every committed case through `truing`, beside what is known of it.

mod judge;
mod table;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::expectation::Provenance;
use crate::measured;
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
    index(&truing, &outcomes, &reports)?;
    table::print(&outcomes);
    let wrong = outcomes.iter().filter(|o| !o.mismatches.is_empty()).count();
    if wrong > 0 {
        bail!("{wrong} of {} cases are not as recorded beside them", outcomes.len());
    }
    Ok(())
}

/// Folders `fixtures/<crate>/<case>` that `truing` can read: measured data in the order in which
/// they are shown, then the others, sorted.
pub(crate) fn case_folders() -> Result<Vec<PathBuf>> {
    let mut folders: Vec<PathBuf> =
        measured::folders().map(|folder| Path::new("fixtures").join(folder)).collect();
    for file in shell::source_files()? {
        if file.starts_with("fixtures/") && file.ends_with("/case.toml") {
            let folder = PathBuf::from(file.trim_end_matches("/case.toml"));
            if !folders.contains(&folder) {
                folders.push(folder);
            }
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
    let mut arguments = vec!["loop", &*case, "--json", "--report", &*report];
    let learnt = provenance.carry.as_ref().map(|earlier| answer_file(reports, earlier));
    if let Some(file) = &learnt {
        arguments.extend(["--carry", file]);
    }
    let closed = truing.run(&arguments)?;
    let name = parts.join("/");
    fs::write(answer_file(reports, &name), closed.json.to_string()).context("no answer kept")?;
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
    Ok(Outcome { name, provenance, loop_json: closed.json, mismatches })
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

/// Where the answer of a case is kept, for those that carry its effects.
fn answer_file(reports: &Path, name: &str) -> String {
    reports.join(format!("{}.json", name.replace('/', "-"))).to_string_lossy().into_owned()
}

/// One page over all cases.
fn index(truing: &Truing, outcomes: &[Outcome], reports: &Path) -> Result<()> {
    let index = reports.join("report.html").to_string_lossy().into_owned();
    let findings = reports.join("findings.json");
    let mut arguments = vec!["index".to_owned(), "--output".to_owned(), index];
    arguments.extend(["--findings".to_owned(), findings.to_string_lossy().into_owned()]);
    let mut by_page: BTreeMap<String, &[String]> = BTreeMap::new();
    for outcome in outcomes {
        let name = format!("{}.html", outcome.name.replace('/', "-"));
        let page = reports.join(&name);
        if page.is_file() {
            arguments.push(page.to_string_lossy().into_owned());
            by_page.insert(name, &outcome.mismatches);
        }
    }
    fs::write(&findings, serde_json::to_string(&by_page)?).context("cannot write the findings")?;
    let answer = truing.run(&arguments)?;
    if answer.code != Some(0) {
        bail!("no index of the reports: {}", answer.message);
    }
    Ok(())
}
