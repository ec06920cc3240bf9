//! The static library that Cargo has built beside this test.

use std::path::{Path, PathBuf};
use std::process::Command;

/// System libraries that Rust's standard library needs on Linux.
pub(crate) const SYSTEM: [&str; 4] = ["-lpthread", "-ldl", "-lm", "-lgcc_s"];

pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The archive, which Cargo builds together with the crate that this test links.
pub(crate) fn archive() -> PathBuf {
    let this = std::env::current_exe().unwrap();
    this.with_file_name("libforce_impedance_c.a")
}

/// Whether a program answers; says that a test is skipped where it does not.
pub(crate) fn has(program: &str, argument: &str) -> bool {
    // The flags of the linker are those of Linux.
    let there = cfg!(target_os = "linux") && Command::new(program).arg(argument).output().is_ok();
    if !there {
        eprintln!("SKIPPED: {program} is not installed");
    }
    there
}

/// Runs a command; its standard output.
pub(crate) fn output_of(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let (out, err) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{command:?}\n{out}\n{err}");
    out.into_owned()
}
