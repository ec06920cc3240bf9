//! Transform between two frames from points measured in both, with its uncertainty.

mod closed_form;
mod effects;
mod error;
mod fit;
mod input;
mod map;
mod model;
mod motion;
mod nested;
mod options;
mod pair;
mod point;
mod proposals;
mod refine;
mod reflection;
mod shape;
mod snooping;
mod spread;
mod statistics;
mod term;
mod transform;
mod uncertainty;

pub use error::{FrameFitError, FreeMotion, InvalidPair};
pub use fit::{FrameFit, fit_frame};
pub use map::FrameMap;
pub use model::FrameModel;
pub use nested::{NestedTest, compare_transforms};
pub use options::{Noise, Options};
pub use pair::{PointPair, Uncertainty};
pub use point::MeasuredPoint;
pub use reflection::{Reflection, ReflectionVerdict};
pub use shape::{Shape, shape_of};
pub use snooping::{Reliability, Snooping, SnoopingOptions, Suspect, reliability, snoop};
pub use transform::{Handedness, Transform};
pub use uncertainty::FrameParameter;
