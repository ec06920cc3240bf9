//! Geometry.
mod asphere;
mod error;
mod euler;
mod line;
mod planar;
mod plane;
mod sphere;
mod surface;
mod wrench;

pub mod coefficients;
pub mod se2;
pub mod se3;
pub mod so3;
pub mod units;

pub use nalgebra;

pub use asphere::{Asphere, AsphereShape};
pub use error::GeometryError;
pub use euler::{EulerAngles, EulerReading};
pub use line::Line;
pub use planar::{PlanarMap, PlanarParts};
pub use plane::Plane;
pub use sphere::Sphere;
pub use surface::{Curvature, Foot, Hit, Surface};
pub use wrench::{LineOfAction, Wrench};
