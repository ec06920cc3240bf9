//! Public behaviour of `pose-icp`.

#![expect(clippy::unwrap_used, reason = "a helper that fails is a test that fails")]

// Touches of a surface that is known exactly.
mod gap;
mod machine_scene;
mod pose_degenerate;
mod pose_exact;
mod pose_freeform;
mod pose_model;
mod pose_scene;
mod pose_weak;
mod program;
mod published;

// Clouds and meshes.
mod cloud;
mod mesh;
