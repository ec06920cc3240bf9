#![doc = include_str!("../README.md")]

pub mod report;

mod case;
mod checked;
mod closed;
mod error;
mod estimates;
mod kinds;
mod page;
mod regrouped;
mod residual;
mod solved;
mod text;
mod text_table;

pub use frame_fit;
pub use ft_center;
pub use geometry;
pub use least_squares;
pub use model_discrepancy;
pub use tracker_lm;

pub use case::{Case, Location, Problem, read_case};
pub use checked::{Checked, Counts, Detectable, Determined, HiddenEffect, ObservableEffect, check};
pub use closed::{
    Closed, JudgedRms, LoopNotObservable, LoopParameter, LoopRemaining, LoopStep, LoopTiming,
    close_loop,
};
pub use error::Error;
pub use estimates::{Estimates, Export};
pub use kinds::{
    AxisErrorEstimate, AxisLocationEstimate, CenterEstimate, DisplacementEstimates,
    DisplacementResidual, FrameEstimate, FrameFitEstimates, FtCenterEstimates, GravityEstimates,
    LineMiss, MountEstimate, PointResidual, StationEstimate, TrackerLmEstimates, TransformStd,
    WrenchEstimate, kinds, write_example,
};
pub use page::{loop_report, solve_report};
pub use residual::Residual;
pub use solved::{SolveTiming, Solved, solve};
