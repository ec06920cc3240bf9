//! Small dense least-squares problems by Levenberg-Marquardt.
//!
//! [`solve`] minimises `½ Σ ρ(‖rᵢ‖²)` over the whitened residuals `rᵢ` of a [`Problem`].

mod check;
mod covariance;
mod error;
mod linearised;
mod loss;
mod null_space;
mod options;
mod prior;
mod problem;
mod qr;
mod report;
mod search;
mod solution;
mod solve;
mod valley;

pub use check::{JacobianCheck, JacobianEntry, check_jacobian};
pub use covariance::{Covariance, covariance};
pub use error::{FreeDirection, SolveError};
pub use loss::{Loss, RobustRows};
pub use options::Options;
pub use prior::{Prior, WithPrior, with_vector_prior};
pub use problem::Problem;
pub use report::{Report, Termination};
pub use solution::Solution;
pub use solve::solve;
