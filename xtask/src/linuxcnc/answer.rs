//! Commands of `truing` as a user types them, and what is read from their answers.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use super::machine::Machine;
use crate::program::{Truing, label_of};

/// Empties the folder of a case and of everything planned from it.
pub(super) fn emptied(folder: &Path) -> Result<PathBuf> {
    if folder.exists() {
        fs::remove_dir_all(folder)?;
    }
    fs::create_dir_all(folder)?;
    Ok(folder.to_owned())
}

pub(super) fn text(path: &Path) -> Result<&str> {
    path.to_str().with_context(|| format!("{} is no text", path.display()))
}

/// Runs a command that must succeed, and says it.
pub(super) fn asked(truing: &Truing, arguments: &[&str]) -> Result<Value> {
    let answer = truing.run(arguments)?;
    let line = arguments.join(" ");
    ensure!(answer.code == Some(0), "truing {line}: {}", answer.message);
    Ok(answer.json)
}

/// Makes a case of a log, with the settings that a user writes into it.
pub(super) fn imported(
    truing: &Truing,
    log: &Path,
    options: &[&str],
    settings: &str,
    case: &Path,
) -> Result<()> {
    let start = ["import", "probe-log", text(log)?];
    asked(truing, &[&start, options, &["--out", text(case)?]].concat())?;
    fs::write(case.join("case.toml"), settings)?;
    Ok(())
}

/// Closes the loop and keeps its answer beside the case.
pub(super) fn closed(truing: &Truing, case: &Path) -> Result<Value> {
    let answer = asked(truing, &["loop", text(case)?, "--json"])?;
    fs::write(case.join("answer.json"), answer.to_string())?;
    println!("    {}: {}", answer["verdict"].as_str().unwrap_or("no verdict"), in_words(&answer));
    Ok(answer)
}

/// Plans, runs the plan on the machine, and fills it with the log; the touches that it made.
pub(super) fn planned(
    truing: &Truing,
    machine: &mut Machine,
    (case, next): (&Path, &Path),
    aim: &[&str],
) -> Result<u64> {
    let answer = case.join("answer.json");
    let start = ["plan", text(case)?, "--answer", text(&answer)?, "--out", text(next)?, "--json"];
    let plan = asked(truing, &[&start, aim].concat())?;
    let count = plan["planned"].as_u64().unwrap_or(0);
    let file = next.join("plan.ngc");
    if count == 0 || !file.exists() {
        return Ok(0);
    }
    let log = machine.run("plan", &fs::read_to_string(&file)?)?;
    asked(truing, &["import", "probe-log", text(&log)?, "--plan", text(next)?])?;
    println!("  plan for {}: {count} touches", plan["aim"].as_str().unwrap_or("the default"));
    Ok(count)
}

/// Names with their sizes, and what each cannot be told apart from.
fn in_words(answer: &Value) -> String {
    let steps = answer["steps"].as_array().map_or(&[][..], Vec::as_slice);
    let one = |step: &Value| {
        let mut words = label_of(step).unwrap_or_else(|| "a shape".to_owned());
        for value in step["parameters"].as_array().into_iter().flatten() {
            let number = |key: &str| value[key].as_f64().unwrap_or(f64::NAN);
            let unit = value["unit"].as_str().unwrap_or_default();
            let _ = write!(words, " {:.4} ± {:.4} {unit}", number("value"), number("std"));
        }
        let rivals: Vec<&str> = step["indistinguishable_from"]
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_str)
            .collect();
        if !rivals.is_empty() {
            let _ = write!(words, " (or {})", rivals.join(", "));
        }
        words
    };
    let all: Vec<String> = steps.iter().map(one).collect();
    if all.is_empty() { "no name".to_owned() } else { all.join("; ") }
}
