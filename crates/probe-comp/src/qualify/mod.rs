//! What a probe adds to its readings, from touches of a reference sphere or ring.

mod problem;
mod qualification;
mod reference;

pub use qualification::{Lobe, Qualification, qualify};
pub use reference::{ProbeTerms, Reference};
