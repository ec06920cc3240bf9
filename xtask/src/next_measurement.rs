//! `cargo xtask bench plan`: the loop, a plan, the planned data from the physics, the loop again.

mod hanging;
mod head;
mod machines;
mod scene;
mod scenes;
mod table;
mod turning;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde_json::Value;

use crate::program::{Truing, class_of, without_subject};
use crate::shell;
use scene::Files;
use scenes::{Situation, situations};

/// How much to run.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Runs per situation.
    #[arg(long, default_value_t = 100)]
    runs: usize,
    /// Only situations whose crate or name contains this.
    #[arg(long)]
    only: Option<String>,
    /// A built program, in place of building one.
    #[arg(long)]
    program: Option<PathBuf>,
    /// Runs left out at the beginning, to look at others than those that something was mended with.
    #[arg(long, default_value_t = 0)]
    skip: u64,
}

/// Runs of a line of the table from which on it is rewritten.
const FOR_THE_PAGE: usize = 100;
/// Distance between the first seeds of situations, far from those of the other benches.
const SEEDS_APART: u64 = 10_000;
/// The first of all.
const FIRST_SEED: u64 = 970_000_000;
/// What is added to a seed for the noise of planned and of evenly spread measurements.
const PLANNED: u64 = 5_000;
/// See [`PLANNED`].
const EVEN: u64 = 7_000;
/// More measurements than any aim needs: a plan ends where it reaches it.
const ENOUGH: &str = "400";

/// What the runs of one situation gave.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    pub(crate) krate: &'static str,
    pub(crate) name: &'static str,
    pub(crate) runs: usize,
    /// Runs in which the loop named the truth alone before anything was planned.
    pub(crate) before: usize,
    /// Runs with a plan, and of these with one that says that it reaches its aim.
    pub(crate) plans: usize,
    pub(crate) reached: usize,
    /// Measurements of all plans.
    pub(crate) measurements: usize,
    /// Runs with the truth alone, or beside nothing but names that the plan says hold it as a part of
    /// themselves: after the plan, with as many spread evenly, with twice as many.
    pub(crate) planned: usize,
    /// Of those after the plan, with the truth alone.
    pub(crate) planned_alone: usize,
    pub(crate) even: usize,
    pub(crate) even_twice: usize,
}

/// Runs the situations and writes their lines of the table of `docs/plan.md`, each as it is done.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let truing = Truing::given(arguments.program.as_deref())?;
    let folder = shell::scratch("plan")?.keep();
    let situations = situations();
    let all: Vec<(&str, &str)> = situations.iter().map(|s| (s.krate, s.name)).collect();
    for (index, situation) in (0..).zip(&situations) {
        let name = format!("{} {}", situation.krate, situation.name);
        if arguments.only.as_ref().is_some_and(|part| !name.contains(part.as_str())) {
            continue;
        }
        let (krate, name) = (situation.krate, situation.name);
        let mut tally = Tally { krate, name, runs: arguments.runs, ..Tally::default() };
        let first = FIRST_SEED + index * SEEDS_APART + arguments.skip;
        for seed in (first..).take(arguments.runs) {
            let folder = folder.join(seed.to_string());
            let planned = tally.planned;
            one(&truing, situation, seed, &folder, &mut tally)?;
            // What went wrong stays to be looked at.
            if tally.planned > planned {
                fs::remove_dir_all(&folder)?;
            }
        }
        table::print_line(&tally);
        if arguments.runs >= FOR_THE_PAGE && arguments.skip == 0 {
            table::write(&tally, &all)?;
        }
    }
    // Stays where anything in it does.
    let _ = fs::remove_dir(&folder);
    Ok(())
}

fn one(
    truing: &Truing,
    situation: &Situation,
    seed: u64,
    folder: &Path,
    tally: &mut Tally,
) -> Result<()> {
    let scene = (situation.make)(seed);
    let case = &folder.join("before");
    let found = truing.asked("loop", scene.files(), case)?;
    if named(&found.json, situation.truth, &[]) == Named::Alone {
        // Nothing is to be planned for.
        tally.before += 1;
        return Ok(fs::remove_dir_all(folder)?);
    }
    let answer = case.join("answer.json");
    fs::write(&answer, found.json.to_string())?;
    let mut arguments =
        vec!["plan", text(case)?, "--json", "--answer", text(&answer)?, "--budget", ENOUGH];
    if let Some(aim) = scene.aim() {
        arguments.extend(["--for", aim]);
    }
    let plan = truing.run(&arguments)?;
    if plan.code != Some(0) {
        // No plan is no success.
        println!("  {seed}: {}", plan.message);
        return Ok(());
    }
    let list = plan.json["plan"].as_array().context("an answer without a plan")?;
    if list.is_empty() {
        println!("  {seed}: no measurement planned: {}", plan.json["would"]);
        return Ok(());
    }
    tally.plans += 1;
    tally.reached += usize::from(plan.json["reached"] == Value::Bool(true));
    tally.measurements += list.len();
    let class = class_of_plan(&plan.json, situation.truth);
    let closed = |files: Files, name: &str| -> Result<Named> {
        let again = truing.asked("loop", files, &folder.join(name))?;
        let found = named(&again.json, situation.truth, &class);
        if found == Named::Otherwise {
            let named = again.json["steps"].as_array().into_iter().flatten().map(class_of);
            println!("    {seed} {name}: {:?}", named.collect::<Vec<_>>());
        }
        Ok(found)
    };
    let with_plan = closed(scene.with_plan(list, seed + PLANNED)?, "planned")?;
    tally.planned += usize::from(with_plan != Named::Otherwise);
    tally.planned_alone += usize::from(with_plan == Named::Alone);
    let even = |count: usize, name: &str| closed(scene.with_even(count, seed + EVEN), name);
    tally.even += usize::from(even(list.len(), "even")? != Named::Otherwise);
    tally.even_twice += usize::from(even(2 * list.len(), "even-twice")? != Named::Otherwise);
    Ok(())
}

/// What a loop said of the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Named {
    /// Without rivals, and nothing else beside it.
    Alone,
    /// The same with rivals that no measurement tells from it.
    InClass,
    Otherwise,
}

/// Whether the effect and nothing else was named, without rivals but those of `class`.
fn named(json: &Value, effect: &str, class: &[String]) -> Named {
    let Some([step]) = json["steps"].as_array().map(Vec::as_slice) else { return Named::Otherwise };
    let found = class_of(step);
    if found == [effect] {
        return Named::Alone;
    }
    let is_known = |name: &&str| *name == effect || class.iter().any(|known| known == name);
    if found.contains(&effect) && found.iter().all(is_known) {
        Named::InClass
    } else {
        Named::Otherwise
    }
}

/// Names that a plan says no measurement tells from an effect.
fn class_of_plan(plan: &Value, effect: &str) -> Vec<String> {
    // Subjects are left out, as in the classes of answers.
    let id = |name: &Value| without_subject(name.as_str().unwrap_or_default()).to_owned();
    let classes = plan["classes"].as_array().into_iter().flatten();
    let own = classes.filter(|class| id(&class["effect"]) == effect);
    own.flat_map(|class| class["with"].as_array().into_iter().flatten()).map(id).collect()
}

fn text(path: &Path) -> Result<&str> {
    path.to_str().with_context(|| format!("{} is no text", path.display()))
}
