//! `cargo xtask web`: the program as a static page, in `target/web`.
//!
//! The page hands a case folder to the program, compiled for WASI, in a worker of the browser. What
//! gives it files and clocks there is the package `@bjorn3/browser_wasi_shim`, fetched by npm.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::shell;

const TARGET: &str = "wasm32-wasip1";
/// Files in memory, clocks and standard output for WASI in a browser; MIT or Apache-2.0.
const SHIM: &str = "@bjorn3/browser_wasi_shim@0.4.2";
/// What the page is, beside the program.
const SOURCE: &str = "crates/truing/web";

/// Compiles the program and puts everything that a server hands out into one folder.
pub(crate) fn run() -> Result<()> {
    let root = shell::root();
    let page = root.join("target/web");
    if page.exists() {
        fs::remove_dir_all(&page).context("target/web")?;
    }
    fs::create_dir_all(page.join("shim")).context("target/web")?;
    shell::cargo(&["build", "--release", "--package", "truing", "--target", TARGET])
        .with_context(|| format!("is the target installed? rustup target add {TARGET}"))?;
    for entry in fs::read_dir(root.join(SOURCE)).context(SOURCE)? {
        let entry = entry?;
        fs::copy(entry.path(), page.join(entry.file_name())).context(SOURCE)?;
    }
    let packed =
        shell::output_of("npm", &["pack", "--silent", "--pack-destination", "target/web", SHIM])
            .context("npm fetches what stands in for the system in a browser")?;
    let archive = page.join(packed.trim());
    // The scripts alone: types and settings are of no use to a browser.
    let mut tar = Command::new("tar");
    tar.arg("-xzf").arg(&archive).arg("-C").arg(page.join("shim"));
    tar.args(["--strip-components=2", "--wildcards", "package/dist/*.js"]);
    ensure!(tar.status().context("cannot start tar")?.success(), "tar failed on {SHIM}");
    fs::remove_file(&archive).context("target/web")?;
    let metadata = shell::metadata(true)?;
    let target = metadata["target_directory"].as_str().context("no target directory")?;
    let built = Path::new(target).join(TARGET).join("release/truing.wasm");
    let bytes =
        fs::copy(&built, page.join("truing.wasm")).with_context(|| built.display().to_string())?;
    println!(
        "wrote target/web, with a program of {} kB; python3 -m http.server -d target/web",
        bytes / 1000
    );
    Ok(())
}
