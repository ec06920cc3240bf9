//! `cargo xtask bench`: speed, solver suites, or the statistics of the loop.

use anyhow::{Context, Result};

use crate::{
    blunders, coverage, loop_speed, next_measurement, peers, power, shared_cause, shell,
    smallest_size, stability,
};

/// What to measure.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Runs the structured solver and the registration beside others on the same problems, and
    /// writes `docs/benchmarks.md` and `docs/benchmarks-icp.md`; installs what it needs and can.
    #[arg(long, value_enum, num_args = 0..=1, default_missing_value = "all")]
    peers: Option<peers::Comparison>,
    /// Rounds of `--peers` in which all run in turn; the least of each counts.
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    #[command(subcommand)]
    what: Option<What>,
}

#[derive(Debug, clap::Subcommand)]
enum What {
    /// Solves the NIST StRD and Moré-Garbow-Hillstrom problems and prints the digits reached.
    Suites,
    /// What closing the loop costs beside solving the declared model.
    Loop(loop_speed::Arguments),
    /// False additions, right names and held-out error of the loop over many simulated cases.
    Power(power::Arguments),
    /// How often 95 % intervals of what is handed back hold the truth, over many simulated cases.
    Coverage(coverage::Arguments),
    /// Cases of one machine, alone and together.
    Machine(shared_cause::Arguments),
    /// How often the right name alone is found once the planned measurements are made.
    Plan(next_measurement::Arguments),
    /// Mistakes in the input that are named, and sound input that is accused.
    Blunders(blunders::Arguments),
    /// How often an effect of the size that `truing check` states is named.
    SmallestSize(smallest_size::Arguments),
    /// Whether answers stay when every reading moves within its last digit.
    Stability(stability::Arguments),
}

/// Name of the bench of least-squares that measures accuracy, not time.
const SUITES: &str = "suites";

/// Runs the benches asked for.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    match &arguments.what {
        Some(What::Suites) => {
            shell::cargo(&["bench", "--package", "least-squares", "--bench", SUITES])
        }
        Some(What::Loop(arguments)) => loop_speed::run(arguments),
        Some(What::Power(arguments)) => power::run(arguments),
        Some(What::Coverage(arguments)) => coverage::run(arguments),
        Some(What::Machine(arguments)) => shared_cause::run(arguments),
        Some(What::Plan(arguments)) => next_measurement::run(arguments),
        Some(What::Blunders(arguments)) => blunders::run(arguments),
        Some(What::SmallestSize(arguments)) => smallest_size::run(arguments),
        Some(What::Stability(arguments)) => stability::run(arguments),
        None => match arguments.peers {
            Some(comparison) => peers::run(comparison, arguments.rounds),
            None => criterion(&["--quick", "--noplot"]),
        },
    }
}

/// Runs every bench once, without measuring.
pub(crate) fn smoke() -> Result<()> {
    criterion(&["--test"])
}

/// One build for all: what a bench measures does not depend on the features of other crates.
fn criterion(options: &[&str]) -> Result<()> {
    let benches = benches()?;
    let timed = benches.iter().filter(|bench| *bench != SUITES);
    let chosen = timed.flat_map(|bench| ["--bench", bench]);
    let mut arguments = vec!["bench", "--workspace", "--all-features"];
    arguments.extend(chosen.chain(["--"]).chain(options.iter().copied()));
    shell::cargo(&arguments)
}

/// Name of every bench.
fn benches() -> Result<Vec<String>> {
    let metadata = shell::metadata(false)?;
    let packages = metadata["packages"].as_array().context("no packages")?;
    let targets = packages.iter().filter_map(|package| package["targets"].as_array()).flatten();
    let benches = targets.filter(|target| target["kind"][0] == "bench");
    Ok(benches.filter_map(|target| Some(target["name"].as_str()?.to_owned())).collect())
}
