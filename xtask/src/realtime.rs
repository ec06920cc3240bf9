//! `cargo xtask realtime`: no panic can be reached from the real-time path of force-impedance.

use std::fs;

use anyhow::{Context, Result, ensure};

use crate::shell;

const PROBE: &str = include_str!("realtime/probe.rs");
const MANIFEST: &str = r#"[package]
name = "probe"
version = "0.0.0"
edition = "2024"

[workspace]

[lib]
crate-type = ["staticlib"]

[dependencies]
force-impedance = { path = "../../crates/force-impedance", default-features = false }
nalgebra = { version = "0.35.0", default-features = false }

[features]
control = []

[profile.release]
panic = "abort"
lto = "fat"
codegen-units = 1
overflow-checks = true
"#;
/// What the panic handler of the probe calls, and nobody provides.
const TRAP: &[u8] = b"a_panic_is_reachable";
/// A function of the probe that must be in the archive.
const PRESENT: &[u8] = b"probe_update";

/// Builds the probe without `std` and looks for the trap; then with a function that can panic,
/// in which the trap must be found.
pub(crate) fn run() -> Result<()> {
    let folder = shell::root().join("target/realtime");
    fs::create_dir_all(folder.join("src")).context("cannot make target/realtime")?;
    fs::write(folder.join("Cargo.toml"), MANIFEST).context("target/realtime/Cargo.toml")?;
    fs::write(folder.join("src/lib.rs"), PROBE).context("target/realtime/src/lib.rs")?;
    fs::copy(shell::root().join("Cargo.lock"), folder.join("Cargo.lock")).context("Cargo.lock")?;
    ensure!(!asks_for_the_trap(&[])?, "a panic can be reached from the real-time path");
    ensure!(
        asks_for_the_trap(&["--features", "control"])?,
        "the check does not find a panic that is there"
    );
    println!("realtime: builds without std; no panic can be reached from the real-time path");
    Ok(())
}

fn asks_for_the_trap(features: &[&str]) -> Result<bool> {
    let manifest = shell::root().join("target/realtime/Cargo.toml");
    let manifest = manifest.to_string_lossy();
    let build = ["build", "--release", "--quiet", "--manifest-path", &manifest];
    shell::cargo(&[&build, features].concat())?;
    let archive = shell::root().join("target/realtime/target/release/libprobe.a");
    let bytes = fs::read(&archive).with_context(|| archive.display().to_string())?;
    let has = |name: &[u8]| bytes.windows(name.len()).any(|window| window == name);
    ensure!(has(PRESENT), "{} does not hold the probe", archive.display());
    Ok(has(TRAP))
}
