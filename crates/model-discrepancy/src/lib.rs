//! Finds what a fitted model is missing.
//!
//! Describe the declared model, its data and the effects that it leaves out as a [`Model`];
//! [`close_loop`] fits it, scores every effect against the residual, adds what is significant and
//! predicts groups it has not seen, and reports the error before and after on data that neither
//! the fit nor the choice has used. Effects that the data cannot tell apart come back as one
//! class, with the measurement that would separate them; what no name fits is reported as
//! structure that remains.
//!
//! The engine knows no domain. Residuals are in the unit they are reported in and are whitened
//! with [`Row::sigma`]; amplitudes are in internal units and reported with
//! [`Parameter::report_factor`].
//!
//! ```
//! use model_discrepancy::nalgebra::DVector;
//! use model_discrepancy::{
//!     Declared, Differenced, Effect, Layout, Options, Parameter, State, Verdict, close_loop,
//! };
//!
//! // A scale read at known lengths: 20 ppm too long, 5 µm off, and a little noise.
//! let length_mm: Vec<f64> = (0..12).map(|i| 50.0 * f64::from(i)).collect();
//! let noise_mm = [3, -5, 1, 4, -2, 0, -4, 5, 2, -1, -3, 1].map(|n| 1e-4 * f64::from(n));
//! let read_mm: Vec<f64> =
//!     length_mm.iter().zip(noise_mm).map(|(l, n)| 0.005 + l * 1.000_02 + n).collect();
//!
//! // The declared model has a zero error and nothing else.
//! let declared = Declared::new(
//!     Layout::scalars(length_mm.iter().map(|l| format!("{l} mm")), "mm", None),
//!     vec![Parameter::new("zero", "mm", 1.0)],
//!     vec![Effect::new(
//!         "scale",
//!         "the scale's divisions are too long",
//!         vec![Parameter::new("scale", "ppm", 1e6)],
//!     )],
//! );
//! let residuals = |at: &State| {
//!     let predicted = |l: &f64| at.base[0] + l * (1.0 + at.amplitudes[0][0]);
//!     DVector::from_iterator(12, length_mm.iter().zip(&read_mm).map(|(l, r)| r - predicted(l)))
//! };
//!
//! let closure = close_loop(&Differenced { declared, residuals }, &[], &Options::default())?;
//! assert_eq!(closure.verdict, Verdict::Explained);
//! let found = &closure.steps[0].parameters[0];
//! assert!((found.value - 20.0).abs() < 3.0 * found.std, "{found:?}");
//! assert!(closure.after.held_out_rms < 0.3 * closure.before.held_out_rms);
//! # Ok::<(), model_discrepancy::LoopError>(())
//! ```
//!
//! Derivatives that are written down are faster: implement [`Model`], or give matrices to
//! [`LinearModel`], and let [`check_tangents`] compare them with differences.

// Layers: each file needs only what stands above it here.
mod count;
mod error;
mod levels;
mod options;
mod progress;

mod model;

mod algebra;

mod noise;

mod tests;

mod choice;

mod answer;

pub use algebra::columns::{Column, EmpiricalCorrection};
pub use algebra::course::{Course, clearest_courses};
pub use algebra::coverage::{coverage_factor, std_over_names};
pub use algebra::f_tail::chance_to_explain;
pub use algebra::interruption::{Interruption, clearest_interruption};
pub use algebra::patch::{Patch, clearest_patches};
pub use algebra::session::Session;
pub use algebra::settling::Settling;
pub use algebra::shown::{Shown, Sought};
pub use algebra::taken::{Left, Taken};
pub use answer::assess::{Assessment, MOST_SIMULATED, Visibility, assess, assess_those};
pub use answer::close_loop::close_loop;
pub use answer::closure::{
    Closure, ErrorSummary, HoldOut, NotObservable, Outcome, ParameterEstimate, Pass, Score,
    Solution, Stability, Step, Verdict,
};
pub use answer::foreseen::Foreseen;
pub use answer::left_over::SCATTER;
pub use answer::opened::{OpenLoop, open_loop};
pub use error::LoopError;
pub use model::{
    Cells, CommonEffect, Covariate, Declared, Differenced, Effect, Extended, Group, Inside, Joint,
    JointPart, Layout, LinearModel, Model, Origin, Parameter, Projected, Proposal, Quantity,
    Remaining, Role, Row, Scope, ShownAmplitude, State, check_tangents, resolution_of,
    whole_tangent,
};
pub use nalgebra;
pub use options::Options;
pub use progress::Progress;
pub use tests::global_test::{GlobalTest, chi2_interval, independent_share, lag_one};
pub use tests::groups_apart::GROUP;
pub use tests::lack_of_fit::{LackOfFit, lack_of_fit};
pub use tests::tails::chance_as_far;
