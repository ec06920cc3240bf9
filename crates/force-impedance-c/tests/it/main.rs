//! Tests of the C interface, one binary.
#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    unsafe_code,
    reason = "helpers of tests: a failure is a failed test, what is skipped is \
              said, and the interface takes pointers"
)]

mod c_program;
#[cfg(target_os = "linux")]
mod hal;
mod header;
mod interface;
mod library;
