//! Trackers that give points: the bundle of their readings, and the loop about it.

mod bundle;
mod calibrate;
mod catalogue;
mod check;
mod faults;
mod model;
mod rows;
mod sight;
mod survey;

pub use calibrate::{StationPose, TargetCalibration, calibrate_targets};
pub use model::{HoldOut, TargetModel, TargetRecords};
pub use survey::{Target, TargetNoise, TargetOptions, TargetSurvey};
