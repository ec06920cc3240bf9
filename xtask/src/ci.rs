//! `cargo xtask ci`: every check in order; the first failure stops.

use anyhow::{Context, Result};
use serde_json::Value;

use crate::{bench, fixtures, linuxcnc, realtime, shell, test, tidy};

/// What to leave out.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Leaves out tests, doc tests and examples, where `cargo xtask test` runs beside.
    #[arg(long)]
    skip_tests: bool,
}

/// Formatting, lints, tests, house rules, dependencies, documentation, the real-time path, a real controller where there is
/// one, benches, fixtures.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    shell::cargo(&["fmt", "--all", "--", "--check"])?;
    // A workspace of its own, whose other checks need Python (`.ci/python`); its form does not.
    shell::cargo(&["fmt", "--manifest-path", "crates/truing-python/Cargo.toml", "--", "--check"])?;
    let lints = ["--release", "--all-targets", "--", "-D", "warnings"];
    let with = |start: &[&'static str]| [start, &lints].concat();
    shell::cargo(&with(&["clippy", "--workspace", "--all-features"]))?;
    for package in members_with_features()? {
        let start = ["clippy", "--package", &package, "--no-default-features"];
        shell::cargo(&[&start[..], &lints].concat())?;
    }
    if !arguments.skip_tests {
        test::run()?;
    }
    tidy::run(tidy::Arguments::default())?;
    deny_where_installed()?;
    shell::cargo_with(
        &["doc", "--release", "--workspace", "--all-features", "--no-deps"],
        &[("RUSTDOCFLAGS", "-D warnings")],
    )?;
    realtime::run()?;
    linuxcnc::run_where_installed()?;
    bench::smoke()?;
    fixtures::run(&fixtures::Arguments { check: true })
}

/// `cargo deny` by the lists that tidy reads too, which only compares what manifests say.
fn deny_where_installed() -> Result<()> {
    if shell::output_of(env!("CARGO"), &["deny", "--version"]).is_err() {
        println!("cargo-deny is not installed: what tidy reads of xtask/deny.toml was checked");
        return Ok(());
    }
    // Without the database of advisories, which is not where packages are.
    let checks = ["licenses", "bans", "sources"];
    shell::cargo(
        &[&["deny", "--offline", "--config", "xtask/deny.toml", "check"], &checks[..]].concat(),
    )
}

/// Members that can be built with less than all their features.
fn members_with_features() -> Result<Vec<String>> {
    let metadata = shell::metadata(false)?;
    let packages = metadata["packages"].as_array().context("no packages")?;
    let has_features = |p: &&Value| p["features"].as_object().is_some_and(|f| !f.is_empty());
    let names = packages.iter().filter(has_features).filter_map(|p| p["name"].as_str());
    Ok(names.map(str::to_owned).collect())
}
