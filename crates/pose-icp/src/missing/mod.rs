//! The declared model as the loop sees it, and what it leaves out.

mod effects;
mod entry;
mod form;
mod intervals;
mod measured;
mod model;
mod proposals;
mod reversal;
mod setup;
mod term;
mod with_effects;

pub use intervals::Fitted;
pub use measured::MeasuredTouch;
pub use model::PoseModel;
