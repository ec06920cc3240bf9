//! `cargo xtask bench stability`: whether answers stay when every reading moves within its resolution.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use crate::page::Block;
use crate::program::{Truing, label_of, write_case};
use crate::repro::case_folders;
use crate::shell;

/// How much to run.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// How far a reading may move, either way, in units of its last recorded digit.
    #[arg(long, default_value_t = 1e-3)]
    share: f64,
    /// Times that every case is read with its readings moved.
    #[arg(long, default_value_t = 2)]
    draws: u64,
    /// Only cases whose folder contains this; the page is written only when all are run.
    #[arg(long)]
    only: Option<String>,
    /// Further folders of cases, one below the other.
    #[arg(long)]
    also: Vec<PathBuf>,
    /// A built program; default: it is built.
    #[arg(long)]
    binary: Option<PathBuf>,
}

const BLOCK: Block = Block { bench: "stability", part: None, heading: "## Answers that stay" };

/// Verdict, and the effects that were added with their subjects.
#[derive(Clone, Debug, PartialEq)]
struct Said {
    verdict: String,
    names: Vec<String>,
}

/// Runs all cases and fails where an answer changes.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let truing = Truing::given(arguments.binary.as_deref())?;
    let wanted = |folder: &PathBuf| {
        let name = folder.to_string_lossy();
        arguments.only.as_ref().is_none_or(|part| name.contains(part.as_str()))
    };
    let mut cases: Vec<PathBuf> = case_folders()?.into_iter().filter(wanted).collect();
    for root in &arguments.also {
        for entry in fs::read_dir(root).with_context(|| root.display().to_string())? {
            let folder = entry?.path();
            if folder.join("case.toml").is_file() && wanted(&folder) {
                cases.push(folder);
            }
        }
    }
    let scratch = shell::scratch("stability")?;
    let (mut moved, mut changed) = (0, Vec::new());
    for case in &cases {
        let case = shell::root().join(case);
        let before = answer(&truing, &case)?;
        for draw in 0..arguments.draws {
            copy_moved(&case, scratch.path(), arguments.share, draw)?;
            let after = answer(&truing, scratch.path())?;
            moved += 1;
            if after != before {
                let line = format!("{}: {before:?} became {after:?}", case.display());
                println!("{line}");
                changed.push(line);
            }
        }
    }
    println!("{} of {moved} answers changed, of {} cases", changed.len(), cases.len());
    if arguments.only.is_none() && arguments.also.is_empty() {
        BLOCK.write(&format!(
            ". All {} committed cases, measured ones included, read {} times with every reading \
             moved by up to {} of its last recorded digit: of {moved} answers {} had another verdict \
             or other names.",
            cases.len(),
            arguments.draws,
            arguments.share,
            changed.len()
        ))?;
    }
    if !changed.is_empty() {
        bail!("{} answers changed", changed.len());
    }
    Ok(())
}

fn answer(truing: &Truing, case: &Path) -> Result<Said> {
    let answer = truing.run(&["loop".as_ref(), case.as_os_str(), "--json".as_ref()])?;
    let Some(verdict) = answer.json["verdict"].as_str() else {
        return Ok(Said { verdict: format!("exit {:?}", answer.code), names: Vec::new() });
    };
    let steps = answer.json["steps"].as_array().map_or(&[][..], Vec::as_slice);
    let names = steps.iter().filter_map(|step: &Value| label_of(step)).collect();
    Ok(Said { verdict: verdict.to_owned(), names })
}

/// Copies a case; every reading of its tables moves by up to `share` of its column's last digit.
fn copy_moved(case: &Path, to: &Path, share: f64, draw: u64) -> Result<()> {
    let mut rng = ChaCha8Rng::seed_from_u64(draw);
    let (mut files, mut moved): (Vec<PathBuf>, Vec<_>) = (Vec::new(), Vec::new());
    for entry in fs::read_dir(case).with_context(|| case.display().to_string())? {
        files.push(entry?.path());
    }
    files.sort();
    for file in files.iter().filter(|file| file.is_file()) {
        let name = file.file_name().context("a file has a name")?;
        let bytes = fs::read(file).with_context(|| file.display().to_string())?;
        let is_table = file.extension().is_some_and(|e| e == "csv");
        let text = is_table.then(|| String::from_utf8(bytes.clone()).ok()).flatten();
        let bytes = text.map_or(bytes, |text| with_moved(&text, share, &mut rng).into_bytes());
        moved.push((name.to_owned(), bytes));
    }
    write_case(moved, to)
}

/// A table of readings that moved. What was set, and not read, stays: whole numbers, and columns that
/// name a place or an angle, whose equal values belong together.
fn with_moved(text: &str, share: f64, rng: &mut ChaCha8Rng) -> String {
    let mut rows =
        text.lines().map(|line| (line.starts_with('#'), line.split(',').collect::<Vec<_>>()));
    let header = rows.clone().find(|(is_comment, _)| !is_comment).map(|(_, cells)| cells);
    let Some(header) = header else { return text.to_owned() };
    let mut digits: BTreeMap<usize, usize> = BTreeMap::new();
    for (_, cells) in rows.clone().filter(|(is_comment, _)| !is_comment).skip(1) {
        for (column, cell) in cells.iter().enumerate() {
            if let Some(here) = decimals(cell) {
                let most = digits.entry(column).or_default();
                *most = here.max(*most);
            }
        }
    }
    let is_read = |column: usize| {
        header
            .get(column)
            .is_some_and(|name| !name.contains("angle") && !name.contains("commanded"))
    };
    let mut out = String::new();
    let mut is_first = true;
    for (is_comment, cells) in &mut rows {
        let stays = is_comment || std::mem::take(&mut is_first);
        let cell = |(column, cell): (usize, &&str)| {
            let digits = digits.get(&column).copied().unwrap_or(0);
            match cell.trim().parse::<f64>() {
                Ok(value) if !stays && digits > 0 && is_read(column) => {
                    let unit = 10f64.powi(-i32::try_from(digits).expect("a few digits"));
                    format!("{}", value + share * unit * rng.random_range(-1.0..1.0))
                }
                _ => (*cell).to_owned(),
            }
        };
        let cells: Vec<String> = cells.iter().enumerate().map(cell).collect();
        // A string takes every character.
        let _ = writeln!(out, "{}", cells.join(","));
    }
    out
}

/// Digits after the point of a number; `None` of anything else.
fn decimals(cell: &str) -> Option<usize> {
    let cell = cell.trim();
    cell.parse::<f64>().ok().filter(|value| value.is_finite())?;
    let mantissa = cell.split(['e', 'E']).next().unwrap_or(cell);
    Some(mantissa.split_once('.').map_or(0, |(_, digits)| digits.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_move_and_the_rest_stays() {
        let text = "# a note, 1.5\npoint,x_mm,angle_deg,use\nP1,1.25,90.5,fit\nP2,7,0.0,check\n";
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let moved = with_moved(text, 0.5, &mut rng);
        let lines: Vec<&str> = moved.lines().collect();
        assert_eq!(lines[..2], text.lines().take(2).collect::<Vec<_>>());
        let x_mm = |line: &str| line.split(',').nth(1).and_then(|c| c.parse::<f64>().ok()).unwrap();
        assert!((x_mm(lines[2]) - 1.25).abs() <= 0.005 && lines[2].ends_with(",90.5,fit"));
        let by = (x_mm(lines[3]) - 7.0).abs();
        assert!(by > 0.0 && by <= 0.005, "{by}");
    }
}
