//! `truing design`: what a machine is to be set to, from numbers alone.

mod force;

pub use force::{
    ContactDesign, ForceDesign, ForceDesignInput, StableRegion, design_force, force_report,
};
