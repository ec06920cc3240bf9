//! Cases of several kinds that were measured on one machine.

mod amplitude;
mod answer;
mod closed;
mod found;
mod linear;
mod page;
mod problem;
mod read;
mod text;

pub use answer::{Agreement, CaseOfMachine, ClosedMachine, StepByCase, StepInCase};
pub use closed::close_machine;
pub use page::machine_report;
pub use problem::MachineProblem;
pub use read::{Machine, is_machine, read_machine};
