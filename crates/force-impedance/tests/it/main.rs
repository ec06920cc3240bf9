//! Tests of the public interface, one binary.
#![allow(
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "helpers of tests: a failure is a failed test, and counts are small"
)]

mod allocation;
mod balance;
mod closed_loop;
mod controller;
mod degenerate;
mod design;
mod discretise;
mod equilibrium;
mod faults;
mod hostile;
mod kinematics;
mod laws;
mod limits_kept;
mod log;
mod log_rig;
mod path;
mod plant;
mod random_cycles;
mod redundancy;
mod rig;
mod usual_head;
mod ways_back;
