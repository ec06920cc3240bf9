//! Small dense least-squares problems by Levenberg-Marquardt.
//!
//! [`solve`] minimises `½ Σ ρ(rᵢ²)` over the whitened residuals `rᵢ` of a [`Problem`].

mod problem;

pub use problem::Problem;
