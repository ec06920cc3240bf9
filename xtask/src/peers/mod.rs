//! `cargo xtask bench --peers`: the same problems for this project and for what others have.

mod icp;
mod icp_contest;

use anyhow::Result;

/// Runs every comparison.
pub(crate) fn run() -> Result<()> {
    icp::run()
}
