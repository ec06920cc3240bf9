//! Trackers that give points: the bundle of their readings, and the loop about it.

#[cfg(feature = "loop")]
mod base;
mod bundle;
mod calibrate;
#[cfg(feature = "loop")]
mod catalogue;
mod check;
#[cfg(feature = "loop")]
mod faults;
#[cfg(feature = "loop")]
mod hold_out;
#[cfg(feature = "loop")]
mod layout;
#[cfg(feature = "loop")]
mod model;
#[cfg(feature = "loop")]
mod records;
#[cfg(feature = "loop")]
mod rows;
mod sight;
mod survey;

pub use calibrate::{StationPose, TargetCalibration, calibrate_targets};
#[cfg(feature = "loop")]
pub use hold_out::HoldOut;
#[cfg(feature = "loop")]
pub use model::TargetModel;
#[cfg(feature = "loop")]
pub use records::TargetRecords;
pub use survey::{Target, TargetNoise, TargetOptions, TargetSurvey};
