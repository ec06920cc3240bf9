//! `cargo xtask bench blunders`: how often mistakes in the input are named, and sound input accused.

mod list;
mod tables;

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use serde_json::Value;

use crate::kinds::force_impedance::polish::Run;
use crate::kinds::frame_fit::survey::Survey;
use crate::kinds::ft_center::press::Session;
use crate::kinds::pose_icp::mirror::Mirror;
use crate::kinds::probe_comp::probe;
use crate::kinds::tracker_lm::{targets, tracer};
use crate::page::Block;
use crate::power::over_seeds;
use crate::power::scene::Scene;
use crate::program::Truing;
use crate::shell;
use list::{Mistake, mistakes};
use tables::Files;

/// How much to run.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Simulated cases per mistake, and as many sound ones per kind for every mistake.
    #[arg(long, default_value_t = 20)]
    seeds: usize,
    /// Only kinds whose name contains this; the page is written only when all are run.
    #[arg(long)]
    only: Option<String>,
    /// A built program; default: it is built.
    #[arg(long)]
    binary: Option<PathBuf>,
}

const BLOCK: Block = Block { bench: "blunders", part: None, heading: "## Mistakes in the input" };
/// Away from the seeds of committed cases and of the statistics of the loop.
const FIRST_SEED: usize = 770_000;
/// Between the first seeds of two mistakes.
const SEEDS_APART: usize = 1000;
/// Change of the misfit that nobody would see beside its scatter from case to case.
const UNSEEN: f64 = 0.05;
/// Share of mistakes that must be named.
const NAMED: f64 = 0.95;

/// A sound case of a kind, by its seed.
type SoundCase = fn(u64) -> Scene;

/// The kinds, and a sound case of each.
const KINDS: [(&str, SoundCase); 7] = [
    ("frame-fit", |seed| Scene::Survey(Survey::new(seed))),
    ("ft-center", |seed| Scene::Session(Session { declare_noise: true, ..Session::new(seed) })),
    ("force-impedance", |seed| Scene::Run(Run::new(seed))),
    ("tracker-lm", |seed| Scene::Tracer(tracer::Run::new(seed))),
    ("tracker-lm targets", |seed| Scene::Targets(targets::Survey::new(seed))),
    ("pose-icp", |seed| Scene::Mirror(Mirror::new(seed))),
    ("probe-comp", |seed| Scene::Probe(probe::Session::new(seed))),
];

/// What became of one mistake.
#[derive(Clone, Debug, Default)]
struct Tally {
    cases: usize,
    named: usize,
    /// Explained, or said to miss nothing.
    confident: usize,
    /// Mistakes that change nothing that can be seen, and are not counted.
    unseen: usize,
    /// Other answers, for people.
    answers: Vec<String>,
}

/// Runs all of them.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let truing = Truing::given(arguments.binary.as_deref())?;
    let root = shell::root().join("target").join("blunders");
    let wanted = |kind: &str| arguments.only.as_ref().is_none_or(|only| kind.contains(only));
    let (mut rows, mut missed) = (String::new(), Vec::new());
    let mut sound = (0, 0);
    for (kind, scene) in KINDS.into_iter().filter(|(kind, _)| wanted(kind)) {
        for (i, mistake) in mistakes(kind).iter().enumerate() {
            let first = FIRST_SEED + SEEDS_APART * i;
            let trials = over_seeds(first..first + arguments.seeds, &root, |seed, folder| {
                let files: Files = scene(seed).simulate().files.into_iter().collect();
                let plain = truing.asked("loop", &files, folder)?.json;
                let tally = Tally::of(&truing, folder, mistake, (files, seed, &plain))?;
                Ok((is_accused(&plain), tally))
            })?;
            let mut tally = Tally::default();
            for (accused, of_seed) in trials {
                sound.0 += 1;
                sound.1 += usize::from(accused);
                tally.add(of_seed);
            }
            let line = tally.line(kind, mistake);
            println!("{}", line.trim_end());
            rows.push_str(&line);
            if !tally.is_good() {
                tally.answers.sort();
                tally.answers.dedup();
                for answer in &tally.answers {
                    println!("        {answer}");
                }
                missed.push(format!("{kind}: {}", mistake.what));
            }
        }
    }
    println!("sound cases accused: {} of {}", sound.1, sound.0);
    if arguments.only.is_none() {
        let (cases, accused) = sound;
        BLOCK.write(&format!(
            ". Sound simulated cases into which one mistake was made, through the built program: named \
             in a step `input:…` or in the refusal; «sure» are those that were called explained, or \
             said to miss nothing; «unseen» change the misfit by less than one part in twenty, as of a \
             part that is the same mirrored, and are not counted. Sound cases accused: {accused} of \
             {cases}.\n\n\
             | kind | mistake | named | sure | unseen |\n|---|---|---|---|---|\n{rows}"
        ))?;
    }
    if sound.1 > 0 || !missed.is_empty() {
        bail!("{} sound cases accused; not named often enough: {}", sound.1, missed.join("; "));
    }
    Ok(())
}

/// Whether a mistake leaves the misfit as it was: a part that is the same
/// mirrored, legs that hardly lean.
fn is_unseen(sound: &Value, wrong: &Value) -> bool {
    let misfit = |json: &Value| json["before"]["train_rms"].as_f64();
    let Some((sound, wrong)) = misfit(sound).zip(misfit(wrong)) else { return false };
    (wrong / sound - 1.0).abs() < UNSEEN
}

fn is_accused(json: &Value) -> bool {
    json["verdict"] == "input-wrong"
}

impl Tally {
    /// One sound case with the mistake made in it; empty where it has no such thing.
    fn of(
        truing: &Truing,
        folder: &Path,
        mistake: &Mistake,
        (mut files, seed, sound): (Files, u64, &Value),
    ) -> Result<Self> {
        if !(mistake.make)(&mut files, seed) {
            return Ok(Self::default());
        }
        let answer = truing.asked("loop", &files, folder)?;
        let steps = answer.json["steps"].as_array().cloned().unwrap_or_default();
        let text = |step: &Value| format!("{} {}", step["effect"], step["description"]);
        let is_input =
            |step: &&Value| step["effect"].as_str().is_some_and(|e| e.starts_with("input:"));
        let said = match answer.code {
            Some(0) => steps.iter().filter(is_input).map(text).collect::<Vec<_>>().join(" "),
            _ => answer.message.clone(),
        };
        let verdict = answer.json["verdict"].as_str().unwrap_or("refused").to_owned();
        let named = mistake.words.iter().any(|word| said.contains(word));
        if !named && is_unseen(sound, &answer.json) {
            return Ok(Self { unseen: 1, ..Self::default() });
        }
        let is_confident = ["explained", "nothing-missing"].contains(&&*verdict);
        let answers = if named { Vec::new() } else { vec![format!("{verdict}: {said}")] };
        let (named, confident) = (usize::from(named), usize::from(is_confident));
        Ok(Self { cases: 1, named, confident, unseen: 0, answers })
    }

    fn add(&mut self, other: Self) {
        self.cases += other.cases;
        self.named += other.named;
        self.confident += other.confident;
        self.unseen += other.unseen;
        self.answers.extend(other.answers);
    }

    fn is_good(&self) -> bool {
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let share = self.named as f64 / self.cases.max(1) as f64;
        self.cases == 0 || share >= NAMED && self.confident == 0
    }

    fn line(&self, kind: &str, mistake: &Mistake) -> String {
        let Self { cases, named, confident, unseen, .. } = self;
        let mark = if self.is_good() { "" } else { " **missed**" };
        format!(
            "| {kind} | {} | {named} of {cases}{mark} | {confident} | {unseen} |\n",
            mistake.what
        )
    }
}
