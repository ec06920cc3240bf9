//! `cargo xtask bench --peers`: the same problems for this project and for what others have.

mod icp;
mod icp_contest;
mod icp_page;
mod solver;
mod solver_scene;

use anyhow::Result;

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
