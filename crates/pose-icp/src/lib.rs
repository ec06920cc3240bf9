//! Where a workpiece lies, from points measured on it.
//!
//! Lengths are in mm, angles in rad. A six-vector is ordered `[tx, ty, tz, rx, ry, rz]` and
//! perturbs on the left, `T = exp(ξ) T̂`; `target_from_source` maps source to target coordinates.

// Clouds and meshes.
mod cloud;
mod mesh;

pub use cloud::{
    CloudTarget, Freedom, Nearest, Objective, Observability, OptionName, PointCloud, RegisterError,
    RegisterOptions, Registration, Side, Termination, WeakDirection, estimate_normals,
    register_to_cloud, thin_out,
};
pub use mesh::{Holes, MeshTarget, TriangleMesh, register_to_mesh, sample_surface};

/// Runs the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
