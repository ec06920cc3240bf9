//! Many small blocks under a few shared parameters.

mod block;
mod covariance;
mod dense;
mod diagnose;
mod eliminate;
mod lanes;
mod options;
mod orthogonal;
mod panels;
mod parts;
mod passes;
mod pattern;
mod point;
mod problem;
mod program;
mod rank;
mod reduced;
mod search;
mod simd;
mod solution;
mod solve;
mod strips;
mod trial;
mod triangle;

pub use covariance::{BorderedCovariance, bordered_covariance};
pub use dense::AsDense;
pub use options::BorderedOptions;
pub use parts::{BlockPart, BlockParts};
pub use pattern::{BlockRows, Pattern};
pub use point::BorderedPoint;
pub use problem::BorderedProblem;
pub use solution::BorderedSolution;
pub use solve::solve_bordered;
