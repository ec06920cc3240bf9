//! The declared models as the loop sees them, and what they leave out.

mod axis_courses;
mod axis_effects;
mod axis_model;
mod axis_proposals;
mod axis_run;
mod axis_searched;
mod commanded;
mod displacement_model;
mod gravity_effects;
mod gravity_model;
mod parameter;
mod press_design;
mod press_doubts;
mod press_drag;
mod press_effects;
mod press_load;
mod press_located;
mod press_model;
mod press_proposals;
mod sensor_errors;

pub use axis_model::{axis_coordinates, positioning_model};
pub use axis_run::{AxisRun, AxisTerm};
pub use displacement_model::{Displacement, DisplacementModel};
pub use gravity_model::GravityModel;
pub use press_model::PressModel;
