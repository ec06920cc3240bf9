//! Behaviour of the solver, seen from outside.
#![expect(clippy::cast_precision_loss, reason = "row and trial counts are small")]
#![expect(clippy::float_cmp, reason = "what is compared for equality is meant exactly")]
#![expect(clippy::unwrap_used, reason = "helpers of tests, too, may fail the test")]

mod between_variance;
#[cfg(feature = "bordered")]
mod bordered;
mod certified;
mod consistency;
mod degenerate;
mod jacobian;
mod laws;
mod priors;
mod problems;
mod report;
mod robust;
#[expect(dead_code, reason = "names and reports are for the bench's tables")]
mod suites;
