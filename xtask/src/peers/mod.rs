//! `cargo xtask bench --peers`: the same problems for this project and for what others have.

mod icp;
mod icp_contest;
mod solver;
mod solver_scene;

use anyhow::Result;

/// Runs every comparison; the solvers `rounds` times in turn.
pub(crate) fn run(rounds: usize) -> Result<()> {
    solver::run(rounds)?;
    icp::run()
}
