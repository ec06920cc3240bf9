//! Public behaviour of `pose-icp`.

mod pose_degenerate;
mod pose_exact;
mod pose_model;
mod pose_scene;
