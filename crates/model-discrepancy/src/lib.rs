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
//! use model_discrepancy::{
//!     Effect, Group, Layout, Model, Options, Parameter, Role, Row, State, Verdict, close_loop,
//! };
//! use nalgebra::{DMatrix, DVector};
//!
//! /// A scale read at known lengths: the declared model has a zero error and nothing else.
//! struct Scale {
//!     layout: Layout,
//!     base: Vec<Parameter>,
//!     effects: Vec<Effect>,
//!     length_mm: Vec<f64>,
//!     read_mm: Vec<f64>,
//! }
//!
//! impl Model for Scale {
//!     fn layout(&self) -> &Layout { &self.layout }
//!     fn base(&self) -> &[Parameter] { &self.base }
//!     fn effects(&self) -> &[Effect] { &self.effects }
//!     fn start(&self) -> DVector<f64> { DVector::zeros(1) }
//!     fn residuals(&self, at: &State) -> DVector<f64> {
//!         let predicted = |l: &f64| at.base[0] + l * (1.0 + at.amplitudes[0][0]);
//!         let residual = self.length_mm.iter().zip(&self.read_mm).map(|(l, r)| r - predicted(l));
//!         DVector::from_iterator(self.read_mm.len(), residual)
//!     }
//!     fn base_jacobian(&self, _: &State) -> DMatrix<f64> {
//!         DMatrix::from_element(self.read_mm.len(), 1, -1.0)
//!     }
//!     fn tangent(&self, _: &State, _: usize) -> DMatrix<f64> {
//!         DMatrix::from_fn(self.read_mm.len(), 1, |i, _| -self.length_mm[i])
//!     }
//! }
//!
//! let parameter = |name: &str, unit: &str, report_factor| Parameter {
//!     name: name.to_owned(), unit: unit.to_owned(), report_factor,
//! };
//! let length_mm: Vec<f64> = (0..12).map(|i| 50.0 * f64::from(i)).collect();
//! // 20 ppm too long, 5 µm off, and a little noise.
//! let noise_mm = [3, -5, 1, 4, -2, 0, -4, 5, 2, -1, -3, 1].map(|n| 1e-4 * f64::from(n));
//! let read_mm = length_mm.iter().zip(noise_mm).map(|(l, n)| 0.005 + l * 1.000_02 + n).collect();
//! let scale = Scale {
//!     layout: Layout {
//!         rows: (0..12)
//!             .map(|i| Row { observation: i, component: 0, sigma: 1.0, reported: true })
//!             .collect(),
//!         observations: (0..12).collect(),
//!         groups: (0..12).map(|i| Group { name: format!("{i}"), role: Role::Fit }).collect(),
//!         unit: "mm".to_owned(),
//!         sigma_declared: false,
//!     },
//!     base: vec![parameter("zero", "mm", 1.0)],
//!     effects: vec![Effect {
//!         id: "scale".to_owned(),
//!         subject: None,
//!         description: "the scale's divisions are too long".to_owned(),
//!         driver: None,
//!         searched: 1,
//!         parameters: vec![parameter("scale", "ppm", 1e6)],
//!     }],
//!     length_mm,
//!     read_mm,
//! };
//!
//! let closure = close_loop(&scale, &[], &Options::default())?;
//! assert_eq!(closure.verdict, Verdict::Explained);
//! let found = &closure.steps[0].parameters[0];
//! assert!((found.value - 20.0).abs() < 3.0 * found.std, "{found:?}");
//! assert!(closure.after.held_out_rms < 0.3 * closure.before.held_out_rms);
//! # Ok::<(), model_discrepancy::LoopError>(())
//! ```

mod agreement;
mod assess;
mod attribution;
mod basis;
mod candidate;
mod check;
mod close_loop;
mod closure;
mod colour;
mod coloured_test;
mod colours;
mod common_scatter;
mod confusable;
mod constancy;
mod coverage;
mod detectable;
mod error;
mod estimate;
mod glance;
mod holdout;
mod interruption;
mod judge;
mod linear;
mod local;
mod model;
mod options;
mod pair;
mod readings;
mod replace;
mod select;
mod separation;
mod shape;
mod significance;
mod summary;
mod system;
mod unforeseen;
mod validate;
mod vector_noise;
mod verdict;
mod whiteness;

pub use assess::{Assessment, Visibility, assess};
pub use check::check_tangents;
pub use close_loop::close_loop;
pub use closure::{
    Alternative, Closure, Column, EmpiricalCorrection, ErrorSummary, HoldOut, NotObservable,
    Outcome, ParameterEstimate, Pass, Remaining, Score, Step, Verdict,
};
pub use common_scatter::common_variance;
pub use coverage::{coverage_factor, std_over_names};
pub use error::LoopError;
pub use model::{
    Condensed, Covariate, Effect, Group, Layout, Model, Origin, Parameter, Proposal, Role, Row,
    State,
};
pub use options::Options;
