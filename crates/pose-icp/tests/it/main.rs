//! Public behaviour of `pose-icp`.

mod pose_degenerate;
mod pose_exact;
mod pose_scene;
