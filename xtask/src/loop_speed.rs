//! `cargo xtask bench loop`: what closing the loop costs beside solving the declared model.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result};
use serde_json::Value;

use crate::kinds::frame_fit::survey::{self, Survey};
use crate::kinds::tracker_lm::tracer::{Run, simulate};
use crate::kinds::tracker_lm::tracer_run::Defect;
use crate::kinds::tracker_lm::tracer_tables::tables;
use crate::program::{Truing, number_at, write_case};
use crate::shell;

/// How much to run.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Built programs, measured in turn; default: one is built.
    #[arg(long)]
    program: Vec<PathBuf>,
    /// Runs of each; the least counts, for a busy machine only adds.
    #[arg(long, default_value_t = 3)]
    rounds: usize,
    /// Only situations whose name contains this.
    #[arg(long)]
    only: Option<String>,
}

/// Time between two looks at the memory of a run.
const LOOK: Duration = Duration::from_millis(2);

/// What is measured on one thread.
struct Situation {
    name: &'static str,
    files: Vec<(&'static str, String)>,
}

/// Least of all runs.
#[derive(Clone, Copy)]
struct Cost {
    seconds: f64,
    peak_mib: f64,
}

/// Times `truing solve`, `truing loop` and `truing check` on one thread.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let programs = if arguments.program.is_empty() {
        vec![Truing::given(None)?]
    } else {
        arguments.program.iter().map(|p| Truing::given(Some(p))).collect::<Result<_>>()?
    };
    let root = shell::root().join("target/loop-speed");
    println!("situation | program | solve ms | loop s | in solves | peak MiB | check s");
    for (index, situation) in situations().into_iter().enumerate() {
        if arguments.only.as_ref().is_some_and(|part| !situation.name.contains(part.as_str())) {
            continue;
        }
        let folder = root.join(index.to_string());
        write_case(situation.files, &folder)?;
        let mut least = vec![[None; 3]; programs.len()];
        for _ in 0..arguments.rounds {
            for (truing, least) in programs.iter().zip(&mut least) {
                for (verb, least) in ["solve", "loop", "check"].into_iter().zip(least) {
                    *least = Some(better(*least, cost(truing, verb, &folder)?));
                }
            }
        }
        for (program, least) in least.iter().enumerate() {
            let [Some(solve), Some(closed), Some(check)] = *least else { continue };
            println!(
                "{} | {} | {:.2} | {:.3} | {:.0} | {:.0} | {:.3}",
                situation.name,
                program + 1,
                1e3 * solve.seconds,
                closed.seconds,
                closed.seconds / solve.seconds,
                closed.peak_mib,
                check.seconds,
            );
        }
    }
    Ok(())
}

fn better(known: Option<Cost>, new: Cost) -> Cost {
    known.map_or(new, |known| Cost {
        seconds: known.seconds.min(new.seconds),
        peak_mib: known.peak_mib.min(new.peak_mib),
    })
}

/// Runs one command on one thread. Of a solution the time is what the answer says, which leaves out
/// reading the case; of all else it is what the processor spent on the whole, which other work on the
/// same machine does not lengthen.
fn cost(truing: &Truing, verb: &str, folder: &Path) -> Result<Cost> {
    let answer = folder.join("answer.json");
    let mut child = Command::new(truing.path())
        .args([verb.as_ref(), folder.as_os_str()])
        .args(["--json", "--threads", "1"])
        .stdout(fs::File::create(&answer)?)
        .stderr(Stdio::null())
        .spawn()
        .with_context(|| format!("cannot start {}", truing.path().display()))?;
    let mut cost = Cost { seconds: 0.0, peak_mib: 0.0 };
    while child.try_wait()?.is_none() {
        cost.peak_mib = cost.peak_mib.max(peak_mib(child.id()).unwrap_or(0.0));
        cost.seconds = cost.seconds.max(processor_s(child.id()).unwrap_or(0.0));
        thread::sleep(LOOK);
    }
    let json: Value = serde_json::from_slice(&fs::read(&answer)?).unwrap_or(Value::Null);
    anyhow::ensure!(!json.is_null(), "{verb} of {} has no answer", folder.display());
    if let Some(seconds) = number_at(&json, "timing.solve_s") {
        cost.seconds = seconds;
    }
    Ok(cost)
}

/// Largest resident set of a process so far; `None` where the system does not tell.
fn peak_mib(process: u32) -> Option<f64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kib / 1024.0)
}

/// What all threads of a process have had of a processor so far.
fn processor_s(process: u32) -> Option<f64> {
    let threads = fs::read_dir(format!("/proc/{process}/task")).ok()?;
    let nanoseconds = |thread: fs::DirEntry| -> Option<f64> {
        let text = fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split(' ').next()?.parse().ok()
    };
    Some(threads.filter_map(|thread| nanoseconds(thread.ok()?)).sum::<f64>() * 1e-9)
}

fn situations() -> Vec<Situation> {
    let tracer = |name, run: Run| Situation { name, files: tables(&run, &simulate(&run)) };
    let eight = Run { n_stations: 8, n_angles: 19, record_air: true, ..Run::new(11) };
    let both_ways = Run { both_ways: true, ..Run::new(12) };
    let large = Run {
        n_stations: 8,
        n_mounts: 5,
        n_angles: 73,
        both_ways: true,
        record_air: true,
        ..Run::new(13)
    };
    let backlash = Defect::Backlash(20e-6, [1e-3, 0.0, 2e-3]);
    let drift = Defect::RangeDrift(4e-3);
    let with = |run: &Run, defect| Run { defect, ..run.clone() };
    let surveyed = survey::simulate(&Survey {
        n_fit: 15_000,
        n_check: 5_000,
        record_air: true,
        defect: survey::Defect::Scale(-35e-6),
        ..Survey::new(14)
    });
    vec![
        tracer("608 ranges, nothing missing", eight),
        tracer("1200 ranges, nothing missing", both_ways.clone()),
        tracer("1200 ranges, backlash", with(&both_ways, backlash)),
        tracer("5840 ranges, nothing missing", large.clone()),
        tracer("5840 ranges, backlash", with(&large, backlash)),
        tracer("5840 ranges, drift", with(&large, drift)),
        Situation {
            name: "20000 points, a scale",
            files: vec![("case.toml", surveyed.case_toml), ("pairs.csv", surveyed.pairs_csv)],
        },
    ]
}
