//! `cargo xtask bench --peers`: the same problems through this project's solver and others'.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use super::contender::{Contender, Outcome, compare};
use super::solver_scene::{self, Size};
use super::{build_outside, growth};
use crate::shell;

const SIZES: [Size; 3] = [
    Size { name: "small", stations: 6, reflectors: 3, steps: 37 },
    Size { name: "medium", stations: 8, reflectors: 4, steps: 361 },
    Size { name: "large", stations: 8, reflectors: 4, steps: 3601 },
];
/// CPU time that the system's accounting tells from nought.
const CPU_CLOCK_MS: f64 = 1.0;
/// Page that is written.
const PAGE: &str = "docs/benchmarks.md";

/// Builds what can be built, runs all in turn, prints and writes the table.
pub(super) fn run(rounds: usize) -> Result<()> {
    let folder = shell::root().join("target/peers");
    fs::create_dir_all(&folder)?;
    let truing = build_truing()?;
    let mut contenders = vec![truing_on(&truing, 1), truing_on(&truing, 2)];
    let mut absent = Vec::new();
    match build_ceres("xtask/peers/ceres/lm.cpp", &folder.join("ceres-lm")) {
        Ok(ceres) => {
            contenders.extend([(1, "1e8"), (2, "1e8")].map(|(threads, radius)| Contender {
                name: "Ceres 2.1.0 (Debian), initial trust radius 1e8",
                threads,
                command: command(&ceres, &["FOLDER", &threads.to_string(), "RUNS", radius]),
                solution: "ceres.bin",
                most_steps: usize::MAX,
                most_runs: usize::MAX,
            }));
            contenders.push(Contender {
                name: "Ceres 2.1.0 (Debian), defaults",
                threads: 1,
                command: command(&ceres, &["FOLDER", "1", "RUNS", "1e4"]),
                solution: "ceres.bin",
                most_steps: usize::MAX,
                most_runs: usize::MAX,
            });
        }
        Err(error) => absent.push(format!("Ceres: {error:#}")),
    }
    match build_factrs(&folder) {
        Ok(factrs) => contenders.push(Contender {
            name: "factrs 0.3.0, sparse Cholesky",
            threads: 1,
            command: command(&factrs, &["FOLDER", "RUNS"]),
            solution: "factrs.bin",
            most_steps: usize::MAX,
            most_runs: 5,
        }),
        Err(error) => absent.push(format!("factrs: {error:#}")),
    }
    match install_scipy() {
        Ok(()) => contenders.push(Contender {
            name: "SciPy, trf with a sparse Jacobian",
            threads: 1,
            command: command(Path::new("python3"), &["xtask/peers/scipy/lm.py", "FOLDER", "RUNS"]),
            solution: "scipy.bin",
            most_steps: 361,
            most_runs: 1,
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

fn truing_on(program: &Path, threads: usize) -> Contender {
    let command = command(program, &["FOLDER", "RUNS"]);
    let [most_steps, most_runs] = [usize::MAX; 2];
    let (name, solution) = ("Truing", "truing.bin");
    Contender { name, threads, command, solution, most_steps, most_runs }
}

/// Builds the bench that solves the problem of a folder; its path.
fn build_truing() -> Result<PathBuf> {
    let messages = shell::output_of(
        env!("CARGO"),
        &[
            "bench",
            "--package",
            "least-squares",
            "--bench",
            "tracker",
            "--no-run",
            "--message-format",
            "json-render-diagnostics",
        ],
    )?;
    let mut programs = messages.lines().filter_map(|line| {
        let message: serde_json::Value = serde_json::from_str(line).ok()?;
        (message["target"]["name"] == "tracker")
            .then(|| message["executable"].as_str().map(PathBuf::from))?
    });
    programs.next_back().context("cargo built no bench")
}

/// Compiles the harness, after installing the library where it is missing.
pub(super) fn build_ceres(source: &str, program: &Path) -> Result<PathBuf> {
    let output = program.display().to_string();
    let compile = || {
        shell::output_of(
            "g++",
            &[
                "-O3",
                "-DNDEBUG",
                "-std=c++17",
                "-I/usr/include/eigen3",
                source,
                "-o",
                &output,
                "-lceres",
                "-lglog",
            ],
        )
    };
    if compile().is_err() {
        shell::output_of("apt-get", &["update", "-qq"])?;
        let install = ["install", "-y", "-qq", "--no-install-recommends", "libceres-dev"];
        shell::output_of("apt-get", &install)?;
        compile()?;
    }
    Ok(program.to_owned())
}

/// Builds the program that runs factrs.
fn build_factrs(work: &Path) -> Result<PathBuf> {
    let target = work.join("factrs");
    build_outside(&shell::root().join("xtask/peers/factrs/Cargo.toml"), &target)?;
    Ok(target.join("release/factrs-peer"))
}

/// Installs it where it is missing.
fn install_scipy() -> Result<()> {
    if shell::output_of("python3", &["-c", "import scipy"]).is_err() {
        shell::output_of("python3", &["-m", "pip", "install", "--quiet", "scipy"])?;
    }
    Ok(())
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
    for (contender, Outcome { best, error_mm }) in contenders.iter().zip(outcomes) {
        let own = contenders.iter().position(|c| c.threads == contender.threads);
        let own = &outcomes[own.context("Truing runs on as many threads")?].best;
        #[expect(clippy::cast_precision_loss, reason = "memory is below 2^53 KiB")]
        let peak_mib = best.peak_kib as f64 / 1024.0;
        writeln!(
            page,
            "| {} | {} | {:.3} | {:.1} | {} | {} | {} | {} | {:.1} | {:.3} |",
            contender.name,
            contender.threads,
            best.ms,
            best.ms / own.ms,
            measured(best.cpu_ms, best.cpu_ms),
            measured(best.cpu_ms / own.cpu_ms, own.cpu_ms),
            best.evaluations,
            best.jacobians,
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
