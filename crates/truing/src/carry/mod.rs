//! Effects learnt on one case and carried to another, where they count as declared.

mod former;
mod learnt;
mod matched;
mod model;
mod problem;

pub use learnt::{Learnt, read_learnt};
pub(crate) use learnt::{LearntParameter, LearntStep};
pub use matched::CarriedEffect;
pub(crate) use matched::{EMPIRICAL, Matched, is_of_one_observation, matched};
pub(crate) use model::carrying;
pub use problem::CarryProblem;
