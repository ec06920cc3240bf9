//! A solver beside others on one problem.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde::Deserialize;

use super::solver_scene::{self, Size};
use crate::shell;

/// Relative difference of the costs up to which solvers agree.
const SAME_COST: f64 = 1e-9;

/// A solver with its settings.
pub(super) struct Contender {
    pub(super) name: String,
    pub(super) threads: usize,
    /// Program and arguments; `FOLDER` and `RUNS` are filled in.
    pub(super) command: Vec<String>,
    /// File that it leaves beside the problem.
    pub(super) solution: &'static str,
    /// Most steps that it is given.
    pub(super) most_steps: usize,
    /// Most runs in a round.
    pub(super) most_runs: usize,
    /// Whether it minimises the same sum of squares as the others, and is held against their cost.
    pub(super) is_same_problem: bool,
}

/// What a contender prints per run.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct Run {
    pub(super) ms: f64,
    pub(super) cpu_ms: f64,
    pub(super) cost: f64,
    pub(super) evaluations: u32,
    pub(super) jacobians: u32,
    pub(super) peak_kib: u64,
}

/// The median of all runs of one contender on one problem.
pub(super) struct Outcome {
    pub(super) usual: Run,
    /// Root mean square error of a reflector's coordinate against the truth.
    pub(super) error_mm: f64,
}

/// Runs all in turn, as many rounds as asked for, and checks that all find the same minimum.
pub(super) fn compare(
    contenders: &[&Contender],
    problem: &Path,
    size: Size,
    rounds: usize,
) -> Result<Vec<Outcome>> {
    let mut runs: Vec<Vec<Run>> = contenders.iter().map(|_| Vec::new()).collect();
    // Small problems take no time: more runs of them smooth the clock.
    let repeats = (3601 / size.steps).clamp(2, 50);
    for round in 0..rounds {
        eprintln!("── {}: round {} of {rounds}", size.name, round + 1);
        for (contender, runs) in contenders.iter().zip(&mut runs) {
            runs.extend(contender.run(problem, repeats.min(contender.most_runs))?);
        }
    }
    let truth = solver_scene::read_numbers(&problem.join("truth.bin"))?;
    let mut outcomes = Vec::new();
    for (contender, runs) in contenders.iter().zip(&runs) {
        let of = |part: fn(&Run) -> f64| median(runs.iter().map(part).collect());
        let first = *runs.first().context("no runs")?;
        let usual = Run { ms: of(|r| r.ms), cpu_ms: of(|r| r.cpu_ms), ..first };
        let solution = solver_scene::read_numbers(&problem.join(contender.solution))?;
        // Points come last.
        let points = 3 * size.reflectors * size.steps;
        let of = |numbers: &[f64]| numbers[numbers.len() - points..].to_vec();
        let error_mm = rms_difference(&of(&solution), &of(&truth));
        outcomes.push(Outcome { usual, error_mm });
    }
    let reference = outcomes[0].usual.cost;
    for (contender, outcome) in contenders.iter().zip(&outcomes) {
        if !contender.is_same_problem {
            continue;
        }
        let difference = (outcome.usual.cost / reference - 1.0).abs();
        ensure!(
            difference <= SAME_COST,
            "{} ends at cost {:e} on {}, others at {reference:e}",
            contender.name,
            outcome.usual.cost,
            size.name
        );
    }
    Ok(outcomes)
}

/// The middle one, or the mean of the middle two.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    0.5 * (values[last / 2] + values[last.div_ceil(2)])
}

fn rms_difference(a: &[f64], b: &[f64]) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "there are not that many")]
    let count = a.len() as f64;
    (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / count).sqrt()
}

impl Contender {
    fn run(&self, problem: &Path, repeats: usize) -> Result<Vec<Run>> {
        let (folder, repeats) = (problem.display().to_string(), repeats.to_string());
        let arguments = self.command.iter().map(|argument| match argument.as_str() {
            "FOLDER" => &folder,
            "RUNS" => &repeats,
            _ => argument,
        });
        let words: Vec<&String> = arguments.collect();
        let output = Command::new(words[0])
            .args(&words[1..])
            .env("RAYON_NUM_THREADS", self.threads.to_string())
            .env("OMP_NUM_THREADS", self.threads.to_string())
            .current_dir(shell::root())
            .output()
            .with_context(|| format!("cannot start {}", words[0]))?;
        ensure!(output.status.success(), "{} failed on {folder}", self.name);
        let lines = String::from_utf8(output.stdout)?;
        lines.lines().map(|line| serde_json::from_str(line).context("no JSON")).collect()
    }
}
