//! Tests of the public interface, one binary.
#![allow(
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    reason = "helpers of tests: a failure is a failed test, and counts are small"
)]

mod balance;
mod degenerate;
mod equilibrium;
mod kinematics;
