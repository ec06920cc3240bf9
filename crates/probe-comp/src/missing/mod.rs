//! The declared model as the loop sees it, and what it leaves out.

mod approach_reversal;
mod catalogue;
mod columns;
mod form;
mod measured;
mod model;
mod probe;
mod proposals;
mod term;
mod with_effects;

pub use measured::MeasuredTouch;
pub use model::{ProbeModel, ProbeSetup};
pub use with_effects::ContactChange;
