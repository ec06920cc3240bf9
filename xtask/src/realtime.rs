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
/// The C interface without `std`, its source as it is.
const C_MANIFEST: &str = r#"[package]
name = "force-impedance-c"
version = "0.0.0"
edition = "2024"

[workspace]

[lib]
path = "../../crates/force-impedance-c/src/lib.rs"
crate-type = ["staticlib"]

[dependencies]
force-impedance = { path = "../../crates/force-impedance", default-features = false }
nalgebra = { version = "0.35.0", default-features = false }

[features]
std = []

[profile.release]
panic = "abort"
lto = "fat"
codegen-units = 1
overflow-checks = true

# As releases are: libm wraps its counts of octants, which fit.
[profile.release.package.libm]
overflow-checks = false
"#;
/// What the panic handlers call, and nobody provides.
const TRAP: &[u8] = b"a_panic_is_reachable";
const C_TRAP: &[u8] = b"force_impedance_panicked";
/// Functions that must be in the archives.
const PRESENT: &[u8] = b"probe_update";
const C_PRESENT: &[u8] = b"fi_controller_update";

/// Builds the probe without `std` and looks for the trap, then with a function that can panic, in
/// which the trap must be found; then the C interface.
pub(crate) fn run() -> Result<()> {
    let probe = Archive::lay_out("realtime", MANIFEST, "probe")?;
    let source = shell::root().join("target/realtime/src");
    fs::create_dir_all(&source).context("cannot make target/realtime/src")?;
    fs::write(source.join("lib.rs"), PROBE).context("target/realtime/src/lib.rs")?;
    ensure!(!probe.holds(&[], PRESENT, TRAP)?, "a panic can be reached from the real-time path");
    ensure!(
        probe.holds(&["--features", "control"], PRESENT, TRAP)?,
        "the check does not find a panic that is there"
    );
    let c = Archive::lay_out("realtime-c", C_MANIFEST, "force_impedance_c")?;
    ensure!(!c.holds(&[], C_PRESENT, C_TRAP)?, "a panic can be reached from the C interface");
    println!(
        "realtime: builds without std; no panic can be reached from the real-time path, nor from \
         the C interface"
    );
    Ok(())
}

/// A static library outside the workspace.
struct Archive {
    folder: String,
    library: &'static str,
}

impl Archive {
    fn lay_out(folder: &str, manifest: &str, library: &'static str) -> Result<Self> {
        let folder = format!("target/{folder}");
        let at = shell::root().join(&folder);
        fs::create_dir_all(&at).with_context(|| format!("cannot make {folder}"))?;
        fs::write(at.join("Cargo.toml"), manifest).with_context(|| folder.clone())?;
        fs::copy(shell::root().join("Cargo.lock"), at.join("Cargo.lock")).context("Cargo.lock")?;
        Ok(Self { folder, library })
    }

    /// Builds it; whether it holds a name, beside one that it must hold.
    fn holds(&self, features: &[&str], present: &[u8], wanted: &[u8]) -> Result<bool> {
        let manifest = shell::root().join(&self.folder).join("Cargo.toml");
        let manifest = manifest.to_string_lossy();
        let build = ["build", "--release", "--quiet", "--manifest-path", &manifest];
        // As it is shipped, whatever profile is tested beside.
        let shipped = [("CARGO_PROFILE_RELEASE_DEBUG_ASSERTIONS", "false")];
        shell::cargo_with(&[&build, features].concat(), &shipped)?;
        let path = format!("{}/target/release/lib{}.a", self.folder, self.library);
        let bytes = fs::read(shell::root().join(&path)).with_context(|| path.clone())?;
        let has = |name: &[u8]| bytes.windows(name.len()).any(|window| window == name);
        ensure!(has(present), "{path} does not hold {}", String::from_utf8_lossy(present));
        Ok(has(wanted))
    }
}
