//! `cargo xtask fuzz`: every reader of foreign files under libFuzzer.
//!
//! The readers and the inputs that they start from lie in `xtask/fuzz`; the tests of `truing` run
//! the same functions on the same inputs without libFuzzer. Inputs that reach further are gathered
//! in `target/fuzz/corpus`, findings in `target/fuzz/findings`.

use std::fs;
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::shell;

/// What to run, and for how long.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Time for each reader.
    #[arg(long, value_name = "N", default_value_t = 60)]
    seconds: u32,
    /// Readers by the names of `xtask/fuzz/corpus`; all of them by default.
    #[arg(value_name = "READER")]
    readers: Vec<String>,
}

const FOLDER: &str = "xtask/fuzz";
const TARGET: &str = "target/fuzz";
/// An input that takes longer hangs: instruments make linear algebra some forty times as slow, and the
/// slowest of the committed ones takes half a second without.
const HANG_S: u32 = 300;
/// Memory that no input of some kilobytes may need: of the process, and in one allocation.
const MOST_MB: u32 = 3072;
const MOST_AT_ONCE_MB: u32 = 1024;

/// Runs readers in turn; those with a finding are named at the end.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    is_there("cargo-fuzz", &["fuzz", "--version"], "cargo install --locked cargo-fuzz")?;
    is_there("a nightly compiler", &["+nightly", "--version"], "rustup toolchain install nightly")?;
    let known = readers()?;
    if let Some(unknown) = arguments.readers.iter().find(|name| !known.contains(name)) {
        bail!("there is no reader `{unknown}`; there are {}", known.join(", "));
    }
    let asked = if arguments.readers.is_empty() { &known } else { &arguments.readers };
    for folder in ["corpus", "findings"] {
        let folder = shell::root().join(TARGET).join(folder);
        fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    }
    let mut found = Vec::new();
    for reader in asked {
        if !ends_well(reader, arguments.seconds)? {
            found.push(reader.as_str());
        }
    }
    ensure!(
        found.is_empty(),
        "findings in {}: their inputs are in {TARGET}/findings; mend the cause and put the input \
         into {FOLDER}/corpus",
        found.join(", ")
    );
    println!("fuzz: {} readers, {} s each, no finding", asked.len(), arguments.seconds);
    Ok(())
}

/// Names of the readers: those of the folders of their inputs.
fn readers() -> Result<Vec<String>> {
    let folder = shell::root().join(FOLDER).join("corpus");
    let entries = fs::read_dir(&folder).with_context(|| folder.display().to_string())?;
    let mut names = Vec::new();
    for entry in entries {
        names.push(entry?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// `cargo` by the name that the user calls, which takes `+nightly`.
fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new("cargo");
    command.args(arguments).current_dir(shell::root());
    command
}

fn is_there(what: &str, arguments: &[&str], install: &str) -> Result<()> {
    let output = cargo(arguments).output();
    let is_there = output.is_ok_and(|output| output.status.success());
    ensure!(is_there, "fuzzing needs {what}: `{install}`");
    Ok(())
}

fn ends_well(reader: &str, seconds: u32) -> Result<bool> {
    let grown = format!("{TARGET}/corpus/{reader}");
    fs::create_dir_all(shell::root().join(&grown)).with_context(|| grown.clone())?;
    let given = format!("{FOLDER}/corpus/{reader}");
    eprintln!("── {reader}, {seconds} s");
    let run = ["+nightly", "fuzz", "run", "--fuzz-dir", FOLDER, "--target-dir", TARGET, "reader"];
    let status = cargo(&run)
        .args([&grown, &given, "--"])
        .arg(format!("-dict={FOLDER}/words.dict"))
        .arg(format!("-artifact_prefix={TARGET}/findings/{reader}-"))
        .arg(format!("-max_total_time={seconds}"))
        .arg(format!("-timeout={HANG_S}"))
        .arg(format!("-rss_limit_mb={MOST_MB}"))
        .arg(format!("-malloc_limit_mb={MOST_AT_ONCE_MB}"))
        .args(["-seed=1", "-detect_leaks=0", "-print_final_stats=1"])
        .env("READER", reader)
        .env("RAYON_NUM_THREADS", "1")
        .status()
        .context("cannot start `cargo fuzz run`")?;
    Ok(status.success())
}
