//! Everything that reads what others wrote, each as a function of bytes that must end, in an answer
//! or in an error, whatever the bytes are.
//!
//! Run under libFuzzer by `cargo xtask fuzz`, and on the committed inputs by the tests of `truing`,
//! which needs no nightly compiler.

mod answer;
mod bundle;
mod case;
mod check;
mod page;
mod probe_log;
mod program;
mod register;
mod shape;
mod step;
mod stream;
mod table;

/// Reads bytes; a panic is a finding.
pub(crate) type Reader = fn(&[u8]);

/// Every reader, by the name that the folder of its inputs has.
pub(crate) const READERS: [(&str, Reader); 11] = [
    ("answer", answer::read),
    ("case", case::read),
    ("check", check::read),
    ("page", page::read),
    ("probe-log", probe_log::read),
    ("program", program::read),
    ("register", register::read),
    ("shape", shape::read),
    ("step", step::read),
    ("stream", stream::read),
    ("table", table::read),
];
