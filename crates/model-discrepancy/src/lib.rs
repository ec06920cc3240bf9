//! Finds what a fitted model is missing.

mod assess;
mod attribution;
mod autocorrelation;
mod basis;
mod candidate;
mod check;
mod close_loop;
mod closure;
mod confusable;
mod constancy;
mod detectable;
mod error;
mod estimate;
mod holdout;
mod judge;
mod linear;
mod model;
mod options;
mod pair;
mod replace;
mod select;
mod separation;
mod shape;
mod significance;
mod summary;
mod system;
mod validate;
mod vector_noise;
mod verdict;
mod whiteness;

pub use assess::{Assessment, Visibility, assess};
pub use check::check_tangents;
pub use close_loop::close_loop;
pub use closure::{
    Closure, ErrorSummary, HoldOut, NotObservable, Outcome, ParameterEstimate, Pass, Remaining,
    Score, Step, Verdict,
};
pub use error::LoopError;
pub use model::{
    Covariate, Effect, Group, Layout, Model, Origin, Parameter, Proposal, Role, Row, State,
};
pub use options::Options;
