//! Geometry.
pub use nalgebra;
