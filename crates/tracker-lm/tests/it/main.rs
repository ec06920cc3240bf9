//! Tests of the public interface.
#![expect(clippy::unwrap_used, reason = "a test that unwraps nothing is a failed test")]
#![expect(clippy::cast_precision_loss, reason = "counts of a test are far below 2^53")]

mod catalogue;
mod closing;
mod consistency;
mod degenerate;
mod elevation;
mod exports;
mod find_axis;
mod first_order;
mod head;
mod perfect;
mod recovery;
mod scene;
mod targets;
