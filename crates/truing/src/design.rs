//! `truing design`: what a machine is to be set to, from numbers alone.

mod card;
mod force;

pub use card::force_report;
pub use force::{ContactDesign, ForceDesign, ForceDesignInput, StableRegion, design_force};
