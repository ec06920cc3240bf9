//! The pose of a part whose surface is known exactly.

mod aperture;
mod chart;
mod edge;
mod fit;
mod gap;
mod height;
mod options;
mod parameter;
mod part;
mod pose_fit;
mod rows;
mod search;
mod singular;
mod start;
mod touch;
mod triangle;
mod weak;

pub(crate) use chart::Chart;
pub use edge::{EdgeTouches, SideTouches};
pub(crate) use fit::check_touches;
pub use fit::fit_pose;
pub use gap::{Gap, gap_at};
pub use height::{Height, height_at};
pub use options::{LateralPrior, Noise, PoseOptions};
pub use parameter::{PoseParameter, PoseStart};
pub use part::Part;
pub use pose_fit::PoseFit;
pub(crate) use rows::Whitened;
pub use start::start_from_touches;
pub use touch::{Tip, TipSide, Touch};
pub use weak::{WeakComponent, WeakMotion};
