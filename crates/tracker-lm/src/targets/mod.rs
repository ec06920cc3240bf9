//! Trackers that give points: the bundle of their readings, and the loop about it.

mod bundle;
mod calibrate;
mod catalogue;
mod check;
mod faults;
mod hold_out;
mod model;
mod rows;
mod sight;
mod survey;

pub use calibrate::{StationPose, TargetCalibration, calibrate_targets};
pub use hold_out::HoldOut;
pub use model::{TargetModel, TargetRecords};
pub use survey::{Target, TargetNoise, TargetOptions, TargetSurvey};
