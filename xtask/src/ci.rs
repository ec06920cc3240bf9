//! `cargo xtask ci`: every check in order; the first failure stops.

use anyhow::{Context, Result};
use serde_json::Value;

use crate::{bench, fixtures, realtime, shell, test, tidy};

/// What to leave out.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Leaves out tests, doc tests and examples, where `cargo xtask test` runs beside.
    #[arg(long)]
    skip_tests: bool,
}

/// Formatting, lints, tests, house rules, documentation, the real-time path, benches, fixtures.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    shell::cargo(&["fmt", "--all", "--", "--check"])?;
    lint(&["--workspace", "--all-features", "--all-targets"])?;
    // Alone, each with what it asks for itself; then their tests and examples, all together.
    let lean = members_with_features()?;
    for package in lean.iter().filter(|package| *package != ASKS_FOR_MOST) {
        lint(&["--package", package, "--no-default-features", "--lib"])?;
    }
    let packages = lean.iter().flat_map(|package| ["--package", package]);
    let together: Vec<&str> =
        ["--no-default-features", "--all-targets"].into_iter().chain(packages).collect();
    lint(&together)?;
    if !arguments.skip_tests {
        test::run()?;
    }
    tidy::run(tidy::Arguments::default())?;
    shell::cargo_with(
        &["doc", "--release", "--workspace", "--all-features", "--no-deps"],
        &[("RUSTDOCFLAGS", "-D warnings")],
    )?;
    realtime::run()?;
    bench::smoke()?;
    fixtures::run(&fixtures::Arguments { check: true })
}

/// What this one asks for of the crates that they share is what all together get.
const ASKS_FOR_MOST: &str = "tracker-lm";

fn lint(of: &[&str]) -> Result<()> {
    shell::cargo(&[&["clippy", "--release"], of, &["--", "-D", "warnings"]].concat())
}

/// Members that can be built with less than all their features.
fn members_with_features() -> Result<Vec<String>> {
    let metadata = shell::metadata(false)?;
    let packages = metadata["packages"].as_array().context("no packages")?;
    let has_features = |p: &&Value| p["features"].as_object().is_some_and(|f| !f.is_empty());
    let names = packages.iter().filter(has_features).filter_map(|p| p["name"].as_str());
    Ok(names.map(str::to_owned).collect())
}
