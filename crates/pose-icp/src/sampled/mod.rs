//! The method of document \[D\]: iterative closest points on a sampled model, in two levels.
//!
//! Kept as published, so that its figures can be rerun; [`fit_pose`](crate::fit_pose) is better in
//! every respect.

mod counts;
mod iteration;
mod method;
mod model_cloud;

pub use counts::{Patch, measuring_points, optimal_ratio};
pub use method::{SampledFit, SampledMethod, SampledOptions, SampledPass, fit_pose_on_samples};
