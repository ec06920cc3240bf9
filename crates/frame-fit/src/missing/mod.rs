//! The declared model as the loop sees it, and what it leaves out.

mod effects;
mod finite_motion;
mod model;
mod point;
mod proposals;
mod term;
mod tip_effects;
mod tip_model;
mod with_effects;

pub use model::FrameModel;
pub use point::MeasuredPoint;
pub use tip_model::TipModel;
pub use with_effects::{MapWithEffects, NearestSimilarity};
