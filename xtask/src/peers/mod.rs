//! `cargo xtask bench --peers`: the same problems for this project and for what others have.

mod contender;
mod growth;
mod icp;
mod icp_contest;
mod icp_page;
mod solver;
mod solver_scene;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::shell;

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Comparison {
    /// Everything.
    All,
    /// The structured solver.
    Solver,
    /// The registration of clouds.
    Clouds,
}

/// Runs comparisons; the solvers `rounds` times in turn.
pub(crate) fn run(comparison: Comparison, rounds: usize) -> Result<()> {
    if comparison != Comparison::Clouds {
        solver::run(rounds)?;
    }
    if comparison != Comparison::Solver {
        icp::run()?;
    }
    Ok(())
}

/// Builds a package that lies outside of the workspace, as peers do, from its committed lock file.
fn build_outside(manifest: &Path, target: &Path) -> Result<()> {
    let arguments = ["build", "--release", "--locked", "--manifest-path", text(manifest)?];
    shell::cargo_with(&arguments, &[("CARGO_TARGET_DIR", text(target)?)])
}

/// The program that whoever runs the bench puts in a peer's place, by `TRUING_PEER_<name>`; it gets
/// the arguments of ours.
fn overridden(name: &str) -> Option<PathBuf> {
    std::env::var_os(format!("TRUING_PEER_{name}")).map(PathBuf::from)
}

fn text(path: &Path) -> Result<&str> {
    path.to_str().with_context(|| format!("{} is no UTF-8", path.display()))
}
