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
//! use nalgebra::{DMatrix, DVector};
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
//! # Many blocks under a few shared parameters
//!
//! [`solve_bordered`] minimises the same over a shared point and any number of blocks, each with
//! residuals of its own. It eliminates one block after the other and never holds a Jacobian, so
//! that time and memory are linear in the number of blocks. Ten cooling curves with one time
//! constant, and each with a height and a floor of its own:
//!
//! ```
//! use least_squares::{
//!     BlockRows, BorderedOptions, BorderedPoint, BorderedProblem, Pattern, SolveError,
//!     bordered_covariance, solve_bordered,
//! };
//!
//! /// Readings of each curve at 0, 1, 2 … s, good to 0.01.
//! struct Curves { readings: Vec<[f64; 8]>, patterns: Vec<Pattern> }
//!
//! impl BorderedProblem for Curves {
//!     fn shared_dim(&self) -> usize { 1 } // rate
//!     fn block_dim(&self) -> usize { 2 } // height, floor
//!     fn block_count(&self) -> usize { self.readings.len() }
//!     fn patterns(&self) -> &[Pattern] { &self.patterns }
//!
//!     fn residuals(&self, block: usize, shared: &[f64], point: &[f64], out: &mut [f64]) {
//!         for (i, reading) in self.readings[block].iter().enumerate() {
//!             let fallen = (-shared[0] * i as f64).exp();
//!             out[i] = (point[0] * fallen + point[1] - reading) / 0.01;
//!         }
//!     }
//!
//!     fn linearise(&self, block: usize, shared: &[f64], point: &[f64], rows: BlockRows<'_>) {
//!         self.residuals(block, shared, point, rows.residuals);
//!         for i in 0..8 {
//!             let fallen = (-shared[0] * i as f64).exp();
//!             rows.by_block[2 * i] = fallen / 0.01;
//!             rows.by_block[2 * i + 1] = 1.0 / 0.01;
//!             rows.by_shared[i] = -point[0] * i as f64 * fallen / 0.01;
//!         }
//!     }
//! }
//!
//! let curve = |k: usize| {
//!     let height = 1.0 + k as f64;
//!     let error = |i: usize| 0.01 * ((7 * i + 3 * k) as f64).sin();
//!     std::array::from_fn(|i| height * (-0.5 * i as f64).exp() + 0.1 + error(i))
//! };
//! // Every residual depends on both parameters of its curve and on the rate.
//! let patterns = vec![Pattern::dense(8, 2, 1)];
//! let curves = Curves { readings: (0..10).map(curve).collect(), patterns };
//! let start = BorderedPoint { shared: vec![1.0], blocks: [1.0, 0.0].repeat(10) };
//!
//! let options = BorderedOptions::default();
//! let fit = solve_bordered(&curves, start, &options)?;
//! let covariance = bordered_covariance(&curves, &fit.point, &options)?;
//! let sigma = covariance.shared()[(0, 0)].sqrt();
//! assert!((fit.point.shared[0] - 0.5).abs() < 3.0 * sigma);
//! assert!((fit.point.blocks[2 * 4] - 5.0).abs() < 3.0 * covariance.block(4)[(0, 0)].sqrt());
//! # Ok::<(), SolveError<BorderedPoint>>(())
//! ```

mod bordered;
mod check;
mod covariance;
mod error;
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

pub use bordered::{
    AsDense, BlockRows, BorderedCovariance, BorderedOptions, BorderedPoint, BorderedProblem,
    BorderedSolution, Pattern, bordered_covariance, solve_bordered,
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
