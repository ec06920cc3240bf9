//! Geometry.
mod error;
mod euler;
mod line;
mod planar;
mod wrench;

pub mod coefficients;
pub mod se2;
pub mod se3;
pub mod so3;
pub mod units;

pub use nalgebra;

pub use error::GeometryError;
pub use euler::{EulerAngles, EulerReading};
pub use line::Line;
pub use planar::{PlanarMap, PlanarParts};
pub use wrench::{LineOfAction, Wrench};
