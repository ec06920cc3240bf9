//! Logs and paths as the loop sees them, and what their declared models leave out.

mod log_blocks;
mod log_delay;
mod log_effects;
mod log_inside;
mod log_model;
mod log_proposals;
mod log_sensitivity;
mod path;
mod path_model;

pub use log_model::{LogModel, LogOptions};
pub use path::PathSample;
pub use path_model::{PathModel, PathOptions};
