//! Least-squares problems by Levenberg-Marquardt: small dense ones, and many small blocks under
//! a few shared parameters.
//!
//! [`solve`] minimises `½ Σ ρ(‖rᵢ‖²)` over the whitened residuals `r` of a [`Problem`], in rows
//! or blocks `i`, with `ρ(s) = s` unless a robust [`Loss`] is asked for. Because each residual
//! is divided by its standard uncertainty, parameters and covariance come in the problem's own
//! units. Steps are tangent steps: the side on which they perturb is that of
//! [`Problem::retract`].
//!
//! Steps: Levenberg (1944), Marquardt (1963), scaled as by Moré (1978), damped as by Nielsen
//! (1999), bent as by Transtrum and Sethna (2012) where the plain search fails.
//!
//! ```
//! use least_squares::{Options, Problem, SolveError, solve};
//! use least_squares::nalgebra::{DMatrix, DVector};
//!
//! /// A shift of the scale and a shift of the part: their sum is all a reading shows.
//! struct Readings;
//!
//! impl Problem for Readings {
//!     type Point = DVector<f64>;
//!     fn residual_count(&self) -> usize { 2 }
//!     fn tangent_dim(&self) -> usize { 2 }
//!     fn residuals(&self, at: &DVector<f64>, out: &mut DVector<f64>) {
//!         out[0] = (at[0] + at[1] - 1.02) / 0.01;
//!         out[1] = (at[0] + at[1] - 0.98) / 0.01;
//!     }
//!     fn jacobian(&self, _: &DVector<f64>, out: &mut DMatrix<f64>) { out.fill(100.0); }
//!     fn retract(&self, at: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> { at + step }
//!     fn parameter_name(&self, index: usize) -> String { ["scale", "part"][index].to_owned() }
//! }
//!
//! let refused = solve(&Readings, DVector::zeros(2), &Options::default()).unwrap_err();
//! assert!(matches!(refused, SolveError::Unobservable { .. }));
//!
//! let held = Options { held: vec![0], ..Options::default() };
//! let fit = solve(&Readings, DVector::zeros(2), &held)?;
//! assert!((fit.point[1] - 1.0).abs() < 1e-12);
//! assert!((fit.standard_uncertainties()[1] - 0.01 / 2_f64.sqrt()).abs() < 1e-15);
//! # Ok::<(), SolveError>(())
//! ```
//!
//! With the feature `bordered`, on by default, `solve_bordered` minimises the same over a shared
//! point and any number of blocks that have residuals of their own.

// What public items are made of.
pub use nalgebra;

mod between_variance;
#[cfg(feature = "bordered")]
mod bordered;
mod check;
mod covariance;
mod error;
mod factorisation;
mod free_direction;
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
mod sparse_basis;
mod valley;

pub use between_variance::between_variance;
#[cfg(feature = "bordered")]
pub use bordered::{
    AsDense, BlockPart, BlockParts, BlockRows, BorderedCovariance, BorderedOptions, BorderedPoint,
    BorderedProblem, BorderedSolution, Pattern, bordered_covariance, solve_bordered,
};
pub use check::{JacobianCheck, JacobianEntry, check_jacobian};
pub use covariance::{Covariance, covariance};
pub use error::SolveError;
pub use free_direction::FreeDirection;
pub use loss::{Loss, RobustRows};
pub use options::Options;
pub use prior::{Prior, WithPrior, with_vector_prior};
pub use problem::Problem;
pub use report::{Report, Termination};
pub use solution::Solution;
pub use solve::solve;
pub use sparse_basis::sparse_basis;

/// Runs the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
