//! Finds what a fitted model is missing.

mod closure;
mod model;

pub use closure::{
    Closure, ErrorSummary, HoldOut, NotObservable, Outcome, ParameterEstimate, Pass, Remaining,
    Score, Step, Verdict,
};
pub use model::{
    Covariate, Effect, Group, Layout, Model, Origin, Parameter, Proposal, Role, Row, State,
};
