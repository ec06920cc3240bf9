//! Public behaviour of `pose-icp`.
#![expect(clippy::unwrap_used, reason = "a helper that fails is a test that fails")]

// Clouds and meshes.
mod cloud;
mod mesh;
