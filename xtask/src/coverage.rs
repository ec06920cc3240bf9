//! `cargo xtask bench coverage`: how often 95 % intervals of what is handed back hold the truth.

mod machines;
mod situation;
mod situations;
mod table;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde_json::Value;

use crate::program::{Truing, class_of, label_of, number_at};
use crate::shell;
use situation::{Held, Situation, Tally};
use situations::situations;

/// How much to run.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Loops per situation.
    #[arg(long, default_value_t = 300)]
    loops: usize,
    /// Only situations whose crate or name contains this; documents only crates run in full.
    #[arg(long)]
    only: Option<String>,
    /// A built program, in place of building one.
    #[arg(long)]
    program: Option<PathBuf>,
}

/// Distance between the first seeds of situations, far from those of `bench power`.
const SEEDS_APART: usize = 10_000;
/// The first of all.
const FIRST_SEED: usize = 900_000_000;

/// Runs the situations, prints the table and rewrites its block in `docs/validation.md`.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let truing = Truing::given(arguments.program.as_deref())?;
    let folder = shell::scratch("coverage")?;
    let mut tallies = Vec::new();
    let wanted = |s: &Situation| {
        let name = format!("{} {}", s.krate, s.name);
        arguments.only.as_ref().is_none_or(|part| name.contains(part.as_str()))
    };
    for (index, situation) in situations().into_iter().enumerate() {
        if !wanted(&situation) {
            continue;
        }
        let first = FIRST_SEED + index * SEEDS_APART;
        let tally = tally(&truing, situation, first..first + arguments.loops, folder.path())?;
        table::print_lines(&tally);
        tallies.push(tally);
    }
    tallies.retain(|t| situations().iter().all(|s| s.krate != t.situation.krate || wanted(s)));
    table::write_blocks(&tallies)
}

fn tally(
    truing: &Truing,
    situation: Situation,
    seeds: std::ops::Range<usize>,
    folder: &Path,
) -> Result<Tally> {
    let mut tally = Tally { situation, named: 0, loops: seeds.len(), held: BTreeMap::new() };
    for seed in seeds {
        let (files, truths) = (tally.situation.make)(u64::try_from(seed)?);
        let json = truing.asked("loop", files, &folder.join(tally.situation.krate))?.json;
        if !is_named(&json, tally.situation.effect) {
            continue;
        }
        tally.named += 1;
        let factor = number_at(&json, "interval.coverage_factor").context("no coverage factor")?;
        let mut held: BTreeMap<_, Held> = BTreeMap::new();
        for truth in truths {
            let number = |path: &str| number_at(&json, path).with_context(|| path.to_owned());
            let (value, std) = (number(&truth.value)?, number(&truth.std)?);
            let reach = factor * std;
            let end = |n: usize| {
                let interval = truth.interval.as_ref()?;
                number_at(&json, &format!("{interval}.{n}"))
            };
            let (low, high) = (end(0).unwrap_or(value - reach), end(1).unwrap_or(value + reach));
            let of_name = held.entry(truth.name).or_default();
            of_name.held += u32::from((low..=high).contains(&truth.known));
            of_name.all += 1;
        }
        for (name, of_loop) in held {
            tally.held.entry(name).or_default().push(of_loop);
        }
    }
    Ok(tally)
}

/// Whether the effect, or nothing, is all that was accepted.
fn is_named(json: &Value, effect: Option<&str>) -> bool {
    let Some(steps) = json["steps"].as_array() else { return false };
    match effect {
        None => steps.is_empty(),
        Some(effect) => {
            let class = |step: &Value| class_of(step).last().is_some_and(|name| *name == effect);
            let label = |step: &Value| label_of(step).is_some_and(|label| label == effect);
            steps.len() == 1 && (class(&steps[0]) || label(&steps[0]))
        }
    }
}
