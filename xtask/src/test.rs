//! `cargo xtask test`: every test, doc test and example of the workspace.
//!
//! All in the release profile: it is what `cargo xtask repro` and the benches build too, so that
//! a clean checkout compiles everything once, and hundreds of loops are closed at full speed.

use anyhow::{Context, Result};
use serde_json::Value;

use crate::shell;

/// Runs examples, then doc tests, then all other tests, so that the closing lines are those of
/// `cargo test`.
pub(crate) fn run() -> Result<()> {
    let examples = build_examples()?;
    for example in &examples {
        eprintln!("── {example}");
        shell::output_of(example, &[])?;
    }
    println!("{} examples ran and held what they assert", examples.len());
    println!(
        "not run here: benchmarks (cargo xtask bench), fixtures through truing (cargo xtask repro)"
    );
    let test = ["test", "--release", "--workspace", "--all-features"];
    shell::cargo(&[&test[..], &["--doc"]].concat())?;
    shell::cargo(&[&test[..], &["--tests"]].concat())
}

/// Builds the examples of every crate; paths of the programs.
fn build_examples() -> Result<Vec<String>> {
    let messages = shell::output_of(
        env!("CARGO"),
        &[
            "build",
            "--release",
            "--workspace",
            "--all-features",
            "--examples",
            "--message-format",
            "json-render-diagnostics",
        ],
    )?;
    let mut examples = Vec::new();
    for line in messages.lines() {
        let message: Value = serde_json::from_str(line).context("cargo printed no JSON")?;
        if message["target"]["kind"][0] == "example" {
            examples.extend(message["executable"].as_str().map(str::to_owned));
        }
    }
    Ok(examples)
}
