//! `cargo xtask bench blunders`: how often mistakes in the input are named, and sound input accused.

mod list;
mod tables;

use std::path::PathBuf;

use anyhow::{Result, bail};
use serde_json::Value;

use crate::kinds::force_impedance::polish::Run;
use crate::kinds::force_impedance::strokes::Strokes;
use crate::kinds::frame_fit::survey::Survey;
use crate::kinds::frame_fit::tip_poses;
use crate::kinds::ft_center::gravity_scenes;
use crate::kinds::ft_center::press::Session;
use crate::kinds::pose_icp::mirror::Mirror;
use crate::kinds::positioning::positions::{self, Positions};
use crate::kinds::probe_comp::probe;
use crate::kinds::tracker_lm::{targets, tracer};
use crate::page::Block;
use crate::power::over_seeds;
use crate::power::scene::Scene;
use crate::program::{Answer, Truing};
use crate::shell;
use list::{Draw, Mistake, mistakes};
use tables::Files;

/// How much to run.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Simulated cases per mistake, and as many sound ones per kind for every mistake.
    #[arg(long, default_value_t = 20)]
    seeds: usize,
    /// Only kinds whose name contains this; documents only crates run in full.
    #[arg(long)]
    only: Option<String>,
    /// Only mistakes whose description contains this; documents nothing.
    #[arg(long)]
    mistake: Option<String>,
    /// A built program; default: it is built.
    #[arg(long)]
    binary: Option<PathBuf>,
}

/// Away from the seeds of committed cases and of the statistics of the loop.
const FIRST_SEED: usize = 770_000;
/// Between the first seeds of two mistakes.
const SEEDS_APART: usize = 1000;
/// From the seed of a case to that of the same kind of case on another day.
const ANOTHER_DAY: u64 = 500_000;
/// Change of the misfit that nobody would see beside its scatter from case to case.
const UNSEEN: f64 = 0.05;
/// Share of mistakes that must be named.
const NAMED: f64 = 0.95;

/// Files of a sound case of a kind, by its seed.
type SoundCase = fn(u64) -> Vec<(&'static str, String)>;

/// The kinds, and a sound case of each.
const KINDS: [(&str, SoundCase); 15] = [
    ("frame-fit", |seed| Scene::Survey(Survey::new(seed)).simulate().files),
    ("frame-fit poses", tip_poses::files),
    ("ft-center", |seed| {
        let session = Session { declare_noise: true, ..Session::new(seed) };
        Scene::Session(session).simulate().files
    }),
    ("ft-center displacements", |seed| Scene::Positions(Positions::new(seed)).simulate().files),
    ("ft-center gravity", gravity_scenes::sound),
    ("positioning", |seed| positions::iso_tables(&Positions::new(seed))),
    ("positioning deviations", |seed| positions::deviation_tables(&Positions::new(seed))),
    ("positioning rotary", |seed| positions::rotary_tables(&Positions::new(seed))),
    ("force-impedance", |seed| Scene::Run(Run::new(seed)).simulate().files),
    ("force-impedance path", |seed| Scene::Strokes(Strokes::new(seed)).simulate().files),
    ("tracker-lm", |seed| Scene::Tracer(tracer::Run::new(seed)).simulate().files),
    ("tracker-lm targets", |seed| Scene::Targets(targets::Survey::new(seed)).simulate().files),
    ("pose-icp", |seed| Scene::Mirror(Mirror::new(seed)).simulate().files),
    ("probe-comp", |seed| Scene::Probe(probe::Session::new(seed)).simulate().files),
    ("probe-comp approaches", |seed| {
        let session = probe::Session { oblique_rad: OBLIQUE_RAD, ..probe::Session::new(seed) };
        Scene::Probe(session).simulate().files
    }),
];
/// Angle between approach and normal where approaches are recorded.
const OBLIQUE_RAD: f64 = 0.5;

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

/// What became of the mistakes in cases of one crate.
#[derive(Default)]
struct Section {
    rows: String,
    missed: Vec<String>,
    sound: usize,
    accused: usize,
}

/// Runs all of them.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let truing = Truing::given(arguments.binary.as_deref())?;
    let wanted = |kind: &str| arguments.only.as_ref().is_none_or(|only| kind.contains(only));
    let mut all = Section::default();
    for kinds in KINDS.chunk_by(|(a, _), (b, _)| crate_of(a) == crate_of(b)) {
        let asked: Vec<(&str, SoundCase)> =
            kinds.iter().copied().filter(|(kind, _)| wanted(kind)).collect();
        let mut section = Section::default();
        for kind in &asked {
            section.run(&truing, *kind, arguments)?;
        }
        if arguments.mistake.is_none() && !asked.is_empty() && asked.len() == kinds.len() {
            section.write(crate_of(kinds[0].0))?;
        }
        all.sound += section.sound;
        all.accused += section.accused;
        all.missed.extend(section.missed);
    }
    println!("sound cases accused: {} of {}", all.accused, all.sound);
    if all.accused > 0 || !all.missed.is_empty() {
        let missed = all.missed.join("; ");
        bail!("{} sound cases accused; not named often enough: {missed}", all.accused);
    }
    Ok(())
}

/// The first word of a kind.
fn crate_of(kind: &str) -> &str {
    kind.split(' ').next().unwrap_or(kind)
}

impl Section {
    /// Every mistake in cases of a kind.
    fn run(
        &mut self,
        truing: &Truing,
        (kind, scene): (&str, SoundCase),
        arguments: &Arguments,
    ) -> Result<()> {
        let root = shell::scratch("blunders")?;
        let asked = |what: &str| arguments.mistake.as_ref().is_none_or(|m| what.contains(m));
        let mistakes = mistakes(kind);
        for (i, mistake) in mistakes.iter().enumerate().filter(|(_, m)| asked(m.what)) {
            let first = FIRST_SEED + SEEDS_APART * i;
            let trials =
                over_seeds(first..first + arguments.seeds, root.path(), |seed, folder| {
                    let files: Files = scene(seed).into_iter().collect();
                    let other: Files = scene(seed + ANOTHER_DAY).into_iter().collect();
                    let draw = Draw { seed, other: &other };
                    let mut wrong = files.clone();
                    if !(mistake.make)(&mut wrong, &draw) {
                        return Ok(None);
                    }
                    let plain = truing.asked("loop", &files, folder)?.json;
                    let tally = Tally::of(mistake, &truing.asked("loop", &wrong, folder)?, &plain);
                    Ok(Some((accusation(&plain).map(|said| format!("seed {seed}: {said}")), tally)))
                })?;
            let mut tally = Tally::default();
            for (accused, of_seed) in trials.into_iter().flatten() {
                self.sound += 1;
                if let Some(said) = accused {
                    println!("        a sound {kind} case is accused, {said}");
                    self.accused += 1;
                }
                tally.add(of_seed);
            }
            if tally.cases + tally.unseen > 0 {
                self.add(kind, mistake, tally);
            }
        }
        Ok(())
    }

    fn add(&mut self, kind: &str, mistake: &Mistake, mut tally: Tally) {
        let line = tally.line(kind, mistake);
        println!("{}", line.trim_end());
        self.rows.push_str(&line);
        if !tally.is_good() {
            tally.answers.sort();
            tally.answers.dedup();
            for answer in &tally.answers {
                println!("        {answer}");
            }
            self.missed.push(format!("{kind}: {}", mistake.what));
        }
    }

    fn write(&self, name: &str) -> Result<()> {
        let Self { rows, sound, accused, .. } = self;
        let heading = format!("### Mistakes in the input of {name}");
        let block = Block { bench: "blunders", part: Some(name), heading: &heading };
        block.write(&format!(
            ". Sound cases accused: {accused} of {sound}.\n\n\
             | kind | mistake | named | sure | unseen |\n|---|---|---|---|---|\n{rows}"
        ))
    }
}

/// Whether a mistake leaves the misfit as it was: a part that is the same
/// mirrored, legs that hardly lean.
fn is_unseen(sound: &Value, wrong: &Value) -> bool {
    let misfit = |json: &Value| json["before"]["train_rms"].as_f64();
    let Some((sound, wrong)) = misfit(sound).zip(misfit(wrong)) else { return false };
    (wrong / sound - 1.0).abs() < UNSEEN
}

/// What a case is accused of.
fn accusation(json: &Value) -> Option<String> {
    let step = (json["verdict"] == "input-wrong").then(|| &json["steps"][0])?;
    Some(format!("{} {}", step["effect"], step["description"]))
}

impl Tally {
    /// One case with a mistake made in it, beside what is said of the sound one.
    fn of(mistake: &Mistake, answer: &Answer, sound: &Value) -> Self {
        let steps = answer.json["steps"].as_array().cloned().unwrap_or_default();
        let text = |step: &Value| format!("{} {}", step["effect"], step["description"]);
        let is_input =
            |step: &&Value| step["effect"].as_str().is_some_and(|e| e.starts_with("input:"));
        // An effect that says itself that it cannot be told from a mistake names that, too.
        let is_tied = |step: &&Value| {
            let rivals = step["indistinguishable_from"].as_array();
            rivals.into_iter().flatten().filter_map(Value::as_str).any(|r| r.starts_with("input:"))
        };
        let rivals = steps.iter().filter(is_tied);
        let said = match answer.code {
            Some(0) => {
                let rivals = rivals.filter_map(|step| step["separate_by"].as_str());
                let named = steps.iter().filter(is_input).map(text);
                named.chain(rivals.map(str::to_owned)).collect::<Vec<_>>().join(" ")
            }
            _ => answer.message.clone(),
        };
        let verdict = answer.json["verdict"].as_str().unwrap_or("refused").to_owned();
        let named = mistake.words.iter().any(|word| said.contains(word));
        if !named && is_unseen(sound, &answer.json) {
            return Self { unseen: 1, ..Self::default() };
        }
        let is_confident = !named && ["explained", "nothing-missing"].contains(&&*verdict);
        let answers = if named { Vec::new() } else { vec![format!("{verdict}: {said}")] };
        let (named, confident) = (usize::from(named), usize::from(is_confident));
        Self { cases: 1, named, confident, unseen: 0, answers }
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
