//! Tests of the public interface, one binary.
#![allow(
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    reason = "helpers of tests: a failure is a failed test, and counts are small"
)]

mod allocation;
mod balance;
mod controller;
mod degenerate;
mod design;
mod discretise;
mod equilibrium;
mod faults;
mod hostile;
mod kinematics;
mod log;
mod log_rig;
mod random_cycles;
mod rig;
