//! The declared model as the loop sees it, and what it leaves out.

mod effects;
mod form;
mod measured;
mod model;
mod proposals;
mod setup;
mod term;

pub use measured::MeasuredTouch;
pub use model::PoseModel;
