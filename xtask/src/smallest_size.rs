//! `cargo xtask bench smallest-size`: how often an effect of the size that `truing check` states is
//! named.

mod situations;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde_json::Value;

use crate::page::Block;
use crate::power::{over_seeds, wilson};
use crate::program::{Truing, class_of};
use crate::shell;
use situations::{Situation, situations};

/// How much to run.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Simulated cases per effect.
    #[arg(long, default_value_t = 60)]
    seeds: usize,
    /// Effects are this many times as large as stated; documents nothing unless it is 1.
    #[arg(long, default_value_t = 1.0)]
    times: f64,
    /// Only effects whose crate or name contains this; documents nothing.
    #[arg(long)]
    only: Option<String>,
    /// A built program; default: it is built.
    #[arg(long)]
    binary: Option<PathBuf>,
}

const BLOCK: Block =
    Block { bench: "smallest-size", part: None, heading: "## The size that `truing check` states" };
/// Away from the seeds of all other statistics.
const FIRST_SEED: usize = 660_000_000;
const SEEDS_APART: usize = 10_000;
/// What is promised is nine in ten; of so many effects of a kind, this share of all.
const ASKED: std::ops::RangeInclusive<f64> = 0.86..=0.94;

/// One simulated case.
struct Trial {
    /// The size that was stated, in the unit of the answer.
    size: f64,
    is_named: bool,
    answer: String,
}

/// Runs all of them, prints the shares and rewrites the block of `docs/validation.md`.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let truing = Truing::given(arguments.binary.as_deref())?;
    let wanted = |s: &Situation| {
        let name = format!("{} {}", s.krate, s.effect);
        arguments.only.as_ref().is_none_or(|part| name.contains(part.as_str()))
    };
    let root = shell::scratch("smallest-size")?;
    let (mut rows, mut of_kinds) = (String::new(), Vec::<(&str, usize, usize)>::new());
    for (index, situation) in situations().into_iter().enumerate() {
        if !wanted(&situation) {
            continue;
        }
        let first = FIRST_SEED + index * SEEDS_APART;
        let mut trials =
            over_seeds(first..first + arguments.seeds, root.path(), |seed, folder| {
                trial(&truing, &situation, seed, (folder, arguments.times))
            })?;
        trials.sort_by(|a, b| a.size.total_cmp(&b.size));
        let (named, all) = (trials.iter().filter(|t| t.is_named).count(), trials.len());
        match of_kinds.last_mut().filter(|(krate, ..)| *krate == situation.krate) {
            Some((_, n, of)) => (*n, *of) = (*n + named, *of + all),
            None => of_kinds.push((situation.krate, named, all)),
        }
        let line = format!(
            "| {} | {} | {:.3} {} | {} |",
            situation.krate,
            situation.effect,
            trials[all / 2].size,
            situation.unit,
            share(named, all)
        );
        println!("{line}");
        for trial in trials.iter().filter(|t| !t.is_named) {
            println!("    {}", trial.answer);
        }
        let _ = writeln!(rows, "{line}");
    }
    for (krate, named, all) in of_kinds {
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let is_kept = ASKED.contains(&(named as f64 / all as f64));
        let missed = if is_kept { "" } else { " **missed**" };
        let line = format!("| {krate} | all of them | | {}{missed} |", share(named, all));
        println!("{line}");
        let _ = writeln!(rows, "{line}");
    }
    #[expect(clippy::float_cmp, reason = "the default, or what was typed")]
    let documents = arguments.only.is_none() && arguments.times == 1.0;
    if !documents {
        return Ok(());
    }
    BLOCK.write(&format!(
        ". {} simulated cases per line; 95 % Wilson intervals in brackets; of all effects of a kind \
         together 86 to 94 % are asked for.\n\n\
         | kind | effect | size stated, median | named |\n|---|---|---|---|\n{rows}",
        arguments.seeds
    ))
}

fn share(named: usize, all: usize) -> String {
    let (low, high) = wilson::interval(named, all);
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let percent = 100.0 * named as f64 / all as f64;
    format!("{percent:.0} % [{:.0}, {:.0}]", 100.0 * low, 100.0 * high)
}

/// Asks of a case with nothing wrong how large the effect must be, and names it in the same case with
/// an effect of that size.
fn trial(
    truing: &Truing,
    situation: &Situation,
    seed: u64,
    (folder, times): (&Path, f64),
) -> Result<Trial> {
    let asked = |verb, size| -> Result<Value> {
        Ok(truing.asked(verb, (situation.make)(seed, size).simulate().files, folder)?.json)
    };
    let checked = asked("check", 0.0)?;
    let size = stated(&checked, situation)
        .with_context(|| format!("`check` states no size of {}", situation.effect))?;
    let closed = asked("loop", times * size)?;
    let steps = closed["steps"].as_array().cloned().unwrap_or_default();
    let name = situation.name();
    let is_it = |step: &Value| class_of(step).contains(&name);
    let names: Vec<_> = steps.iter().flat_map(class_of).collect();
    let verdict = closed["verdict"].as_str().unwrap_or("no answer");
    let is_named = !steps.is_empty() && steps.iter().all(is_it);
    Ok(Trial { size, is_named, answer: format!("{}: {verdict}", names.join(", ")) })
}

/// The smallest size of the amplitude that the situation is about.
fn stated(checked: &Value, situation: &Situation) -> Option<f64> {
    let observable = checked["observable"].as_array()?;
    let label = |o: &&Value| crate::program::label_of(o).is_some_and(|l| l == situation.effect);
    let amplitudes = observable.iter().find(label)?["detectable"].as_array()?;
    let amplitude = amplitudes.iter().find(|a| a["name"] == situation.amplitude)?;
    if amplitude["unit"] != situation.unit {
        return None;
    }
    amplitude["value"].as_f64()
}
