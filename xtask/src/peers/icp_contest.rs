//! Programs that take turns on a problem, and the medians of their figures.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::contender::median;

/// A B A B A B, so that a machine that slows down slows down everybody.
const ROUNDS: usize = 3;
/// Runs within a turn; the first warms the caches up and counts nothing.
const RUNS: &str = "2";

/// A program that registers: `PROGRAM [ARGUMENTS] FOLDER THREADS RUNS`, one JSON line a run.
pub(super) struct Contestant {
    name: &'static str,
    program: PathBuf,
    arguments: Vec<String>,
}

impl Contestant {
    pub(super) fn new(name: &'static str, program: &Path, arguments: &[&str]) -> Self {
        let arguments = arguments.iter().map(|&a| a.to_owned()).collect();
        Self { name, program: program.to_owned(), arguments }
    }

    /// Standard output by lines.
    fn answers<A: DeserializeOwned>(
        &self,
        folder: &Path,
        threads: usize,
        more: &[&str],
    ) -> Result<Vec<A>> {
        let mut command = Command::new(&self.program);
        command.args(&self.arguments).arg(folder).arg(threads.to_string()).args(more);
        answers_of(&mut command)
    }
}

/// Standard output by lines.
fn answers_of<A: DeserializeOwned>(command: &mut Command) -> Result<Vec<A>> {
    let output = command.output().with_context(|| format!("cannot start {command:?}"))?;
    ensure!(output.status.success(), "{command:?} failed ({})", output.status);
    let lines = String::from_utf8(output.stdout).context("no UTF-8")?;
    let read = |line| serde_json::from_str(line).with_context(|| format!("{command:?}: {line}"));
    lines.lines().map(read).collect()
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct Run {
    pub(super) wall_s: f64,
    pub(super) cpu_s: f64,
    /// Building the search tree apart, where a program can.
    pub(super) build_s: Option<f64>,
    /// Processor time of a nearest-neighbour query, where a program measures it.
    pub(super) query_ns: Option<f64>,
    /// Processor time of reading a query and its answer.
    pub(super) floor_ns: Option<f64>,
    pub(super) error_um: f64,
    pub(super) converged: Option<bool>,
}

/// How many starts of one angle and shift led to the pose.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct Cell {
    pub(super) angle_deg: f64,
    pub(super) shift_mm: f64,
    pub(super) found: usize,
    pub(super) starts: usize,
}

/// How many starts of one size led to a pose.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct PoseCell {
    pub(super) size: f64,
    pub(super) found: usize,
    pub(super) starts: usize,
    pub(super) median_us: f64,
}

/// Median figures of a program on a problem.
pub(super) struct Row {
    pub(super) problem: &'static str,
    pub(super) threads: usize,
    pub(super) name: &'static str,
    pub(super) usual: Run,
}

/// Results so far.
#[derive(Default)]
pub(super) struct Contest {
    pub(super) rows: Vec<Row>,
    pub(super) basins: Vec<(&'static str, Vec<Cell>)>,
    pub(super) poses: Vec<(&'static str, Vec<PoseCell>)>,
    /// Errors on drawings of the scan, µm.
    pub(super) drawings: Vec<(&'static str, Vec<f64>)>,
}

impl Contest {
    /// Lets the contestants take turns on a problem.
    pub(super) fn hold(
        &mut self,
        problem: &'static str,
        folder: &Path,
        threads: usize,
        contestants: &[Contestant],
    ) -> Result<()> {
        let mut runs = vec![Vec::new(); contestants.len()];
        for round in 1..=ROUNDS {
            for (contestant, runs) in contestants.iter().zip(&mut runs) {
                eprintln!("{problem}, {threads} threads, round {round}: {}", contestant.name);
                runs.extend(
                    contestant.answers::<Run>(folder, threads, &[RUNS])?.into_iter().skip(1),
                );
            }
        }
        for (contestant, runs) in contestants.iter().zip(runs) {
            let usual = |figure: fn(&Run) -> f64| median(runs.iter().map(figure).collect());
            let last = runs.last().with_context(|| format!("{} said nothing", contestant.name))?;
            let usual_of = |figure: fn(&Run) -> Option<f64>| {
                let known: Vec<f64> = runs.iter().filter_map(figure).collect();
                (!known.is_empty()).then(|| median(known))
            };
            let typical = Run {
                wall_s: usual(|r| r.wall_s),
                cpu_s: usual(|r| r.cpu_s),
                build_s: usual_of(|r| r.build_s),
                query_ns: usual_of(|r| r.query_ns),
                floor_ns: usual_of(|r| r.floor_ns),
                ..*last
            };
            self.rows.push(Row { problem, threads, name: contestant.name, usual: typical });
        }
        Ok(())
    }

    /// Lets one program register each of several folders once.
    pub(super) fn drawings(&mut self, contestant: &Contestant, folders: &[PathBuf]) -> Result<()> {
        eprintln!("drawings: {}", contestant.name);
        let mut errors_um = Vec::new();
        for folder in folders {
            errors_um
                .extend(contestant.answers::<Run>(folder, 2, &["1"])?.iter().map(|r| r.error_um));
        }
        self.drawings.push((contestant.name, errors_um));
        Ok(())
    }

    /// Lets one program start from further and further off.
    pub(super) fn basin(
        &mut self,
        contestant: &Contestant,
        folder: &Path,
        more: &[&str],
    ) -> Result<()> {
        eprintln!("basin: {}", contestant.name);
        let cells = contestant.answers(folder, 2, more)?;
        self.basins.push((contestant.name, cells));
        Ok(())
    }
    /// Lets one program find the poses of touched mirrors.
    pub(super) fn poses(
        &mut self,
        name: &'static str,
        program: &Path,
        folder: &Path,
        way: Option<&str>,
    ) -> Result<()> {
        eprintln!("poses: {name}");
        let mut command = Command::new(program);
        command.arg(folder).args(way);
        self.poses.push((name, answers_of(&mut command)?));
        Ok(())
    }
}
