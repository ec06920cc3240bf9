//! `truing design`: what a machine is to be set to, from numbers alone.

mod card;
mod force;
mod micro_plane;

pub use card::force_report;
pub use force::{ContactDesign, ForceDesign, ForceDesignInput, StableRegion, design_force};
pub use micro_plane::{MicroPlane, MicroPlaneInput, design_micro_plane};
