//! Programs that take turns on a problem, and the table of their best figures.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// Turns of each: A B A B A B, so that a machine that slows down slows down everybody.
const ROUNDS: usize = 3;

/// Runs within a turn; the first warms the caches up.
const RUNS: &str = "2";

/// Error beyond which an answer is none, whatever its program says.
const WRONG_UM: f64 = 100.0;

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
        let output = command.output().with_context(|| format!("cannot start {command:?}"))?;
        ensure!(output.status.success(), "{command:?} failed ({})", output.status);
        let lines = String::from_utf8(output.stdout).context("no UTF-8")?;
        let read =
            |line| serde_json::from_str(line).with_context(|| format!("{command:?}: {line}"));
        lines.lines().map(read).collect()
    }
}

#[derive(Clone, Copy, Debug, Deserialize)]
struct Run {
    wall_s: f64,
    cpu_s: f64,
    error_um: f64,
    converged: Option<bool>,
}

/// How many starts of one angle and shift led to the pose.
#[derive(Clone, Copy, Debug, Deserialize)]
struct Cell {
    angle_deg: f64,
    shift_mm: f64,
    found: usize,
    starts: usize,
}

struct Row {
    problem: &'static str,
    threads: usize,
    name: &'static str,
    best: Run,
}

/// Results so far.
#[derive(Default)]
pub(super) struct Contest {
    rows: Vec<Row>,
    basins: Vec<(&'static str, Vec<Cell>)>,
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
                runs.extend(contestant.answers::<Run>(folder, threads, &[RUNS])?);
            }
        }
        for (contestant, runs) in contestants.iter().zip(runs) {
            let least = |figure: fn(&Run) -> f64| runs.iter().map(figure).fold(f64::MAX, f64::min);
            let last = runs.last().with_context(|| format!("{} said nothing", contestant.name))?;
            let best = Run { wall_s: least(|r| r.wall_s), cpu_s: least(|r| r.cpu_s), ..*last };
            self.rows.push(Row { problem, threads, name: contestant.name, best });
        }
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

    /// The page of results.
    pub(super) fn page(&self) -> String {
        format!("{}{}", self.speeds(), self.basin_tables())
    }

    fn basin_tables(&self) -> String {
        let mut page = String::from(
            "\n## From how far off\n\n4000 points on 40 000, 200 mm across, no limit on the \
             distance. Starts that led to within 50 µm, in %, by angle and shift.\n",
        );
        for (name, cells) in &self.basins {
            let mut shifts: Vec<f64> = cells.iter().map(|cell| cell.shift_mm).collect();
            shifts.dedup();
            shifts.truncate(cells.partition_point(|c| c.angle_deg <= cells[0].angle_deg));
            let _ = write!(page, "\n| {name} |");
            for shift in &shifts {
                let _ = write!(page, " {shift} mm |");
            }
            let _ = write!(page, "\n|---|{}", "---|".repeat(shifts.len()));
            for row in cells.chunk_by(|a, b| a.angle_deg.to_bits() == b.angle_deg.to_bits()) {
                let _ = write!(page, "\n| {} deg |", row[0].angle_deg);
                for cell in row {
                    let _ = write!(page, " {} |", 100 * cell.found / cell.starts.max(1));
                }
            }
            page.push('\n');
        }
        page
    }

    fn speeds(&self) -> String {
        let mut page = String::from(
            "# Registration beside packaged peers\n\n\
             Written by `cargo xtask bench --peers`. The problems are those of \
             `xtask/peers/icp/problems.py`. Search tree and registration together, least of \
             several runs, programs in turn. Error: the largest of any source point against the \
             pose that made the problem. Ratio: wall time over that of pose-icp.\n\n\
             | problem | threads | program | wall ms | processor ms | ratio | error µm |\n\
             |---|---|---|---|---|---|---|\n",
        );
        for row in &self.rows {
            let ours = self.rows.iter().find(|other| {
                (other.problem, other.threads, other.name) == (row.problem, row.threads, "pose-icp")
            });
            let ratio = ours.map_or(f64::NAN, |ours| row.best.wall_s / ours.best.wall_s);
            let is_answer = row.best.error_um < WRONG_UM && row.best.converged.unwrap_or(true);
            let remark = if is_answer { "" } else { ", not converged" };
            let _ = writeln!(
                page,
                "| {} | {} | {} | {:.1} | {:.1} | {ratio:.1} | {:.2}{remark} |",
                row.problem,
                row.threads,
                row.name,
                row.best.wall_s * 1e3,
                row.best.cpu_s * 1e3,
                row.best.error_um,
            );
        }
        page
    }
}
