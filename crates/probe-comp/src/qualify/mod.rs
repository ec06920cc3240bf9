//! What a probe adds to its readings, from touches of a reference sphere or ring.

mod problem;
mod qualification;
mod reference;

#[cfg(feature = "loop")]
pub(crate) use problem::shifts;
pub use qualification::{Lobe, ProbeUncertainty, Qualification, qualify};
pub use reference::{ProbeTerms, Reference};
