//! The declared model as the loop sees it, and what it leaves out.

pub(crate) mod axis_effects;
mod change;
mod changes;
pub(crate) mod course;
mod courses;
pub(crate) mod effects;
pub(crate) mod found;
pub(crate) mod layout;
pub(crate) mod looked_through;
pub(crate) mod model;
mod moves;
mod of_axis;
pub(crate) mod orders;
mod proposals;
pub(crate) mod reduce;
mod reduction;
pub(crate) mod session;
mod sights;
mod solved;
pub(crate) mod stops;
mod with_effects;

pub use model::TrackerModel;
