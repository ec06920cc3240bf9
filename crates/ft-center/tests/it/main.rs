//! Tests of the public interface, one binary.
#![allow(
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    clippy::type_complexity,
    reason = "helpers of tests: a failure is a failed test, and counts are small"
)]

mod batch;
mod centroid;
mod coverage;
mod displacement;
mod frame;
mod gravity;
mod hostile;
mod jacobian;
mod locate;
mod monitor;
mod orbit;
mod positioning;
mod positioning_figures;
mod positioning_rivals;
mod press_loop;
mod press_told;
mod pressure;
mod repeatability;
mod saved_frame;
mod simulator;
mod surface_contact;
