//! The declared model as the loop sees it, and what it leaves out.

mod change;
mod changes;
mod course;
pub(crate) mod effects;
pub(crate) mod found;
pub(crate) mod model;
mod moves;
mod proposals;
pub(crate) mod reduce;
mod reduction;
mod sights;
mod with_effects;

pub use model::TrackerModel;
