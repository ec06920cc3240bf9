//! Running other programs from the root of the workspace.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use tempfile::TempDir;

/// Root of the workspace.
pub(crate) fn root() -> PathBuf {
    let manifest_dir = Path::new(env!("CARGO_MANIFEST_DIR"));
    manifest_dir.parent().expect("xtask lives in the workspace").to_path_buf()
}

/// Where one run of a bench writes its cases: two at once do not meet, and nothing is left of it.
pub(crate) fn scratch(bench: &str) -> Result<TempDir> {
    let target = root().join("target");
    std::fs::create_dir_all(&target)?;
    let folder = tempfile::Builder::new().prefix(&format!("{bench}-")).tempdir_in(&target);
    folder.with_context(|| format!("no folder can be made in {}", target.display()))
}

/// Runs `cargo` with inherited output, saying first what it runs.
pub(crate) fn cargo(arguments: &[&str]) -> Result<()> {
    cargo_with(arguments, &[])
}

/// Runs `cargo` with further environment variables.
pub(crate) fn cargo_with(arguments: &[&str], environment: &[(&str, &str)]) -> Result<()> {
    let line = format!("cargo {}", arguments.join(" "));
    eprintln!("── {line}");
    let status = Command::new(env!("CARGO"))
        .args(arguments)
        .envs(environment.iter().copied())
        .current_dir(root())
        .status()
        .with_context(|| format!("cannot start `{line}`"))?;
    ensure!(status.success(), "`{line}` failed ({status})");
    Ok(())
}

/// Standard output of a program, which must succeed.
pub(crate) fn output_of(program: &str, arguments: &[&str]) -> Result<String> {
    output_with(program, arguments, &[])
}

/// Standard output of a program with further environment variables, which must succeed.
pub(crate) fn output_with(
    program: &str,
    arguments: &[&str],
    environment: &[(&str, &OsStr)],
) -> Result<String> {
    let line = format!("{program} {}", arguments.join(" "));
    let output = Command::new(program)
        .args(arguments)
        .envs(environment.iter().copied())
        .current_dir(root())
        .output()
        .with_context(|| format!("cannot start `{line}`"))?;
    ensure!(
        output.status.success(),
        "`{line}` failed ({}): {}",
        output.status,
        String::from_utf8_lossy(&output.stderr).trim()
    );
    String::from_utf8(output.stdout).with_context(|| format!("`{line}` printed no UTF-8"))
}

/// `cargo metadata` of the workspace.
pub(crate) fn metadata(with_dependencies: bool) -> Result<serde_json::Value> {
    let mut arguments = vec!["metadata", "--format-version", "1", "--all-features"];
    if !with_dependencies {
        arguments.push("--no-deps");
    }
    let text = output_of(env!("CARGO"), &arguments)?;
    serde_json::from_str(&text).context("`cargo metadata` printed no JSON")
}

/// Files known to git or new and not ignored, relative to the root, with `/` between folders.
pub(crate) fn source_files() -> Result<Vec<String>> {
    let listing = output_of("git", &["ls-files", "--cached", "--others", "--exclude-standard"])?;
    let exists = |path: &String| root().join(path).is_file();
    let mut files: Vec<String> = listing.lines().map(str::to_owned).filter(exists).collect();
    files.sort();
    files.dedup();
    Ok(files)
}
