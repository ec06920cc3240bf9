//! `cargo xtask bench --peers`: the same problems through this project's solver and others'.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use super::contender::{Contender, Outcome, compare};
use super::solver_scene::{self, Size};
use super::{build_outside, growth, overridden};
use crate::shell;

const SIZES: [Size; 3] = [
    Size { name: "small", stations: 6, reflectors: 3, steps: 37 },
    Size { name: "medium", stations: 8, reflectors: 4, steps: 361 },
    Size { name: "large", stations: 8, reflectors: 4, steps: 3601 },
];
/// `tracker_lm::calibrate` by its formulations: argument, name, and whether that is the problem of all.
const CALIBRATIONS: [(&str, &str, bool); 2] = [
    ("free-points", "Truing, `tracker_lm::calibrate`, free points", true),
    ("joint", "Truing, `tracker_lm::calibrate`, rigid body", false),
];
/// Harness of Ceres.
const LM: &str = "xtask/peers/ceres/lm.cpp";
/// Initial trust radius, and gain of a step that is the last, with which Ceres takes the fewest steps to the same
/// cost.
const TUNED: (&str, &str) = ("1e8", "1e-3");
/// Where Debian has Ceres. Its library aligns for SSE: what is compiled for this machine must, too.
const DEBIAN_CERES: &str = "-I/usr/include/eigen3 -DEIGEN_MAX_ALIGN_BYTES=16 -lceres -lglog";
/// CPU time that the system's accounting tells from nought.
const CPU_CLOCK_MS: f64 = 1.0;
/// Page that is written.
const PAGE: &str = "docs/benchmarks.md";

/// Builds what can be built, runs all in turn, prints and writes the table.
pub(super) fn run(rounds: usize) -> Result<()> {
    let folder = shell::root().join("target/peers");
    fs::create_dir_all(&folder)?;
    let core = bench("least-squares", "tracker")?;
    let calibrate = bench("tracker-lm", "calibrate")?;
    let mut contenders = vec![of_core(&core, 1), of_core(&core, 2)];
    for (way, name, is_same_problem) in CALIBRATIONS {
        contenders.extend([1, 2].map(|threads| Contender {
            name: name.to_owned(),
            command: command(&calibrate, &["FOLDER", "RUNS", way]),
            solution: "calibrate.bin",
            is_same_problem,
            ..of_core(&calibrate, threads)
        }));
    }
    let mut absent = Vec::new();
    match build_ceres("CERES_LM", LM, &folder.join("ceres-lm")) {
        Ok(ceres) => contenders.extend(of_ceres(&ceres, "")?),
        Err(error) => absent.push(format!("Ceres: {error:#}")),
    }
    if let Ok(flags) = std::env::var("TRUING_PEER_CERES_FLAGS") {
        let program = folder.join("ceres-lm-given");
        compile_ceres(LM, &program, &flags)?;
        contenders.extend(of_ceres(&program, " (given)")?.into_iter().take(2));
    }
    match build_factrs(&folder) {
        Ok(factrs) => contenders.push(Contender {
            name: "factrs 0.3.0, sparse Cholesky".to_owned(),
            command: command(&factrs, &["FOLDER", "RUNS"]),
            solution: "factrs.bin",
            most_runs: 5,
            ..of_core(&factrs, 1)
        }),
        Err(error) => absent.push(format!("factrs: {error:#}")),
    }
    match python_with_scipy() {
        Ok(python) => contenders.push(Contender {
            name: "SciPy, trf with a sparse Jacobian".to_owned(),
            command: command(&python, &["xtask/peers/scipy/lm.py", "FOLDER", "RUNS"]),
            solution: "scipy.bin",
            most_steps: 361,
            most_runs: 1,
            ..of_core(&python, 1)
        }),
        Err(error) => absent.push(format!("SciPy: {error:#}")),
    }
    let mut page = String::new();
    for (seed, size) in (101..).zip(SIZES) {
        let problem = folder.join(size.name);
        solver_scene::write(size, seed, &problem)?;
        let able: Vec<_> = contenders.iter().filter(|c| size.steps <= c.most_steps).collect();
        let outcomes = compare(&able, &problem, size, rounds)?;
        write_table(&mut page, size, &able, &outcomes)?;
    }
    growth::write(&mut page, &folder, &[&contenders[0], &contenders[1]], rounds)?;
    for reason in &absent {
        writeln!(page, "\nNot run: {reason}")?;
    }
    println!("{page}");
    update_page(&page)
}

fn command(program: &Path, arguments: &[&str]) -> Vec<String> {
    let program = program.display().to_string();
    std::iter::once(program).chain(arguments.iter().map(|&a| a.to_owned())).collect()
}

/// The solver by itself.
fn of_core(program: &Path, threads: usize) -> Contender {
    Contender {
        name: "Truing, solver".to_owned(),
        threads,
        command: command(program, &["FOLDER", "RUNS"]),
        solution: "truing.bin",
        most_steps: usize::MAX,
        most_runs: usize::MAX,
        is_same_problem: true,
    }
}

/// Ceres as it is fastest, and as it comes.
fn of_ceres(program: &Path, which: &str) -> Result<Vec<Contender>> {
    let version = shell::output_of(super::text(program)?, &["--version"])?;
    let with = |(threads, name, radius, tolerance): (usize, &str, &str, &str)| Contender {
        name: format!("Ceres {}{which}, {name}", version.trim()),
        command: command(program, &["FOLDER", &threads.to_string(), "RUNS", radius, tolerance]),
        solution: "ceres.bin",
        ..of_core(program, threads)
    };
    Ok([
        (1, "tuned", TUNED.0, TUNED.1),
        (2, "tuned", TUNED.0, TUNED.1),
        (1, "default radius and stopping", "1e4", "0"),
    ]
    .map(with)
    .into())
}

/// Builds a bench that solves the problem of a folder; its path.
fn bench(package: &str, name: &str) -> Result<PathBuf> {
    let format = "json-render-diagnostics";
    let messages = shell::output_of(
        env!("CARGO"),
        &["bench", "--package", package, "--bench", name, "--no-run", "--message-format", format],
    )?;
    let mut programs = messages.lines().filter_map(|line| {
        let message: serde_json::Value = serde_json::from_str(line).ok()?;
        (message["target"]["name"] == name)
            .then(|| message["executable"].as_str().map(PathBuf::from))?
    });
    programs.next_back().context("cargo built no bench")
}

/// Compiles a harness, after installing Debian's library where it is missing; `name` is that under
/// which another program may be given.
pub(super) fn build_ceres(name: &str, source: &str, program: &Path) -> Result<PathBuf> {
    if let Some(given) = overridden(name) {
        return Ok(given);
    }
    if compile_ceres(source, program, DEBIAN_CERES).is_err() {
        shell::output_of("apt-get", &["update", "-qq"])?;
        let install = ["install", "-y", "-qq", "--no-install-recommends", "libceres-dev"];
        shell::output_of("apt-get", &install)?;
        compile_ceres(source, program, DEBIAN_CERES)?;
    }
    Ok(program.to_owned())
}

fn compile_ceres(source: &str, program: &Path, flags: &str) -> Result<()> {
    let mut arguments = vec!["-O3", "-DNDEBUG", "-march=native", "-std=c++17", source];
    arguments.extend(["-o", super::text(program)?]);
    arguments.extend(flags.split_whitespace());
    shell::output_of("g++", &arguments)?;
    Ok(())
}

/// Builds the program that runs factrs.
fn build_factrs(work: &Path) -> Result<PathBuf> {
    if let Some(given) = overridden("FACTRS") {
        return Ok(given);
    }
    let target = work.join("factrs");
    build_outside(&shell::root().join("xtask/peers/factrs/Cargo.toml"), &target)?;
    Ok(target.join("release/factrs-peer"))
}

/// A Python that has `SciPy`, which is installed where it is missing.
fn python_with_scipy() -> Result<PathBuf> {
    let python = overridden("PYTHON").unwrap_or_else(|| "python3".into());
    let name = super::text(&python)?;
    if shell::output_of(name, &["-c", "import scipy"]).is_err() {
        shell::output_of(name, &["-m", "pip", "install", "--quiet", "scipy"])?;
    }
    Ok(python)
}

fn write_table(
    page: &mut String,
    size: Size,
    contenders: &[&Contender],
    outcomes: &[Outcome],
) -> Result<()> {
    let Size { name, stations, reflectors, steps } = size;
    writeln!(page, "\n### {name}: {stations} stations, {reflectors} reflectors, {steps} steps\n")?;
    let head = "| solver | threads | ms | over Truing | CPU ms | over Truing | evaluations | \
                Jacobians | peak MiB | rms error of a coordinate, µm |";
    writeln!(page, "{head}\n|---|---|---|---|---|---|---|---|---|---|")?;
    for (contender, Outcome { usual, error_mm }) in contenders.iter().zip(outcomes) {
        let own = contenders.iter().position(|c| c.threads == contender.threads);
        let own = &outcomes[own.context("Truing runs on as many threads")?].usual;
        #[expect(clippy::cast_precision_loss, reason = "memory is below 2^53 KiB")]
        let peak_mib = usual.peak_kib as f64 / 1024.0;
        writeln!(
            page,
            "| {} | {} | {:.3} | {:.1} | {} | {} | {} | {} | {:.1} | {:.3} |",
            contender.name,
            contender.threads,
            usual.ms,
            usual.ms / own.ms,
            measured(usual.cpu_ms, usual.cpu_ms),
            measured(usual.cpu_ms / own.cpu_ms, own.cpu_ms),
            usual.evaluations,
            usual.jacobians,
            peak_mib,
            1e3 * error_mm
        )?;
    }
    Ok(())
}

/// A figure, or a dash where the CPU time that it comes from is below the system's clock.
fn measured(value: f64, cpu_ms: f64) -> String {
    if cpu_ms < CPU_CLOCK_MS { "–".to_owned() } else { format!("{value:.1}") }
}

/// Replaces what stands between the page's marks.
fn update_page(tables: &str) -> Result<()> {
    const MARKS: [&str; 2] = ["<!-- peers: begin -->\n", "<!-- peers: end -->"];
    let file = shell::root().join(PAGE);
    let text = fs::read_to_string(&file).context(PAGE)?;
    let (before, rest) = text.split_once(MARKS[0]).context("the page has no begin mark")?;
    let (_, after) = rest.split_once(MARKS[1]).context("the page has no end mark")?;
    let cpu = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let model = model.map_or("unknown", |(_, name)| name);
    let rustc = shell::output_of("rustc", &["--version"])?;
    let made = format!("On {model}, {}.\n", rustc.trim());
    fs::write(file, format!("{before}{}{made}{tables}{}{after}", MARKS[0], MARKS[1]))?;
    Ok(())
}
