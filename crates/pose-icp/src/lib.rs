//! Where a workpiece lies, from points measured on it.
//!
//! Lengths are in mm, angles in rad. A six-vector is ordered `[tx, ty, tz, rx, ry, rz]` and
//! perturbs on the left, `T = exp(ξ) T̂`; `target_from_source` maps source to target coordinates.

// Clouds and meshes.
mod cloud;

pub use cloud::{PointCloud, RegisterError, Side};
