//! `cargo xtask bench power`: how often the loop is right, over many simulated cases.

pub(crate) mod cell;
pub(crate) mod cells;
pub(crate) mod detectable;
pub(crate) mod harder_cells;
pub(crate) mod scene;
pub(crate) mod table;
pub(crate) mod trial;
pub(crate) mod wilson;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{fs, thread};

use anyhow::{Context, Result, bail};

use crate::program::Truing;
use crate::shell;
use cell::{Cell, Question};
use cells::cells;
use trial::Trial;

/// How much to run.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Simulated cases per cell.
    #[arg(long, default_value_t = 200)]
    seeds: usize,
    /// Cases per cell to leave out before these, for cases that nobody has looked at; documents nothing.
    #[arg(long, default_value_t = 0)]
    skip: usize,
    /// Only cells whose crate or situation contains this; documents only crates run in full.
    #[arg(long)]
    only: Option<String>,
    /// A built program; default: it is built.
    #[arg(long)]
    binary: Option<PathBuf>,
}

/// Processes that run at the same time.
pub(crate) const N_WORKERS: usize = 2;
/// Distance between the first seeds of cells, so that no two cells share a case.
pub(crate) const SEEDS_PER_CELL: usize = 1_000_000;

/// What a cell gave.
pub(crate) struct Tally {
    pub(crate) cell: Cell,
    pub(crate) hits: usize,
    pub(crate) trials: usize,
    /// Median of held-out error over noise.
    pub(crate) ratio: f64,
    /// How often each answer was given, the most frequent first.
    pub(crate) answers: Vec<(String, usize)>,
}

impl Tally {
    /// Whether the cell is as good as it must be.
    pub(crate) fn good(&self) -> bool {
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let share = self.hits as f64 / self.trials as f64;
        match self.cell.question {
            Question::Honest(_) => share >= 0.95,
            Question::Named(_) => share >= 0.95 && self.ratio <= 1.1,
            Question::BothNamed(_) => share >= 0.9 && self.ratio <= 1.1,
            Question::FalseAddition | Question::ConfidentWrongName | Question::OtherName(_) => {
                share <= 0.05
            }
        }
    }
}

/// Runs the cells, prints the table and rewrites the crates' sections of `docs/validation.md`.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    if arguments.seeds == 0 {
        bail!("at least one seed per cell is needed");
    }
    let truing = Truing::given(arguments.binary.as_deref())?;
    let wanted = |cell: &Cell| {
        let name = format!("{} {}", cell.krate, cell.situation);
        arguments.only.as_ref().is_none_or(|part| name.contains(part.as_str()))
    };
    let mut tallies = Vec::new();
    for (index, cell) in cells().into_iter().enumerate() {
        if wanted(&cell) {
            let first = index * SEEDS_PER_CELL + arguments.skip;
            let trials = trials(&truing, &cell, first, arguments.seeds)?;
            let tally = tally(cell, &trials);
            table::print_line(&tally);
            tallies.push(tally);
        }
    }
    if arguments.skip > 0 {
        return Ok(());
    }
    tallies.retain(|t| cells().iter().all(|c| c.krate != t.cell.krate || wanted(c)));
    table::write_sections(&tallies)
}

/// Runs the seeds of one cell on all workers.
pub(crate) fn trials(
    truing: &Truing,
    cell: &Cell,
    first: usize,
    n_seeds: usize,
) -> Result<Vec<Trial>> {
    let folder = shell::scratch("power")?;
    over_seeds(first..first + n_seeds, folder.path(), |seed, folder| {
        trial::run(truing, cell, seed, folder)
    })
}

/// What every seed gives, on all workers, each with a folder of its own below `root`.
pub(crate) fn over_seeds<T: Send>(
    seeds: Range<usize>,
    root: &Path,
    trial: impl Fn(u64, &Path) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let next = AtomicUsize::new(seeds.start);
    let trials = Mutex::new(Vec::with_capacity(seeds.len()));
    let work = |worker: usize| -> Result<()> {
        let folder = root.join(worker.to_string());
        fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds.end {
                return Ok(());
            }
            let trial = trial(u64::try_from(seed).context("seed too large")?, &folder)?;
            trials.lock().expect("no worker panics").push(trial);
        }
    };
    thread::scope(|scope| {
        let work = &work;
        let workers: Vec<_> = (0..N_WORKERS).map(|w| scope.spawn(move || work(w))).collect();
        workers.into_iter().try_for_each(|w| w.join().expect("no worker panics"))
    })?;
    Ok(trials.into_inner().expect("no worker panics"))
}

pub(crate) fn tally(cell: Cell, trials: &[Trial]) -> Tally {
    let mut ratios: Vec<f64> = trials.iter().filter_map(|t| t.ratio).collect();
    ratios.sort_by(f64::total_cmp);
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for trial in trials {
        *counts.entry(&trial.answer).or_default() += 1;
    }
    let mut answers: Vec<(String, usize)> =
        counts.into_iter().map(|(answer, count)| (answer.to_owned(), count)).collect();
    answers.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    Tally {
        cell,
        hits: trials.iter().filter(|t| t.hit).count(),
        trials: trials.len(),
        ratio: ratios.get(ratios.len() / 2).copied().unwrap_or(f64::NAN),
        answers,
    }
}
