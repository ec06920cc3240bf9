//! Transform between two frames from points measured in both, with its uncertainty.
//!
//! [`fit_frame`] finds the map `T = target_from_source` of a family ([`Transform`]: translation,
//! rigid, similarity, affine; planar or spatial) that minimises `Σ rᵢᵀ Σᵢ⁻¹ rᵢ` over the residuals
//! `rᵢ = pᵢ − T qᵢ` of the pairs `pᵢ` (target frame) and `qᵢ` (source frame).
//!
//! Lengths are in mm, angles in rad. Parameters are those of a small motion on the left about a
//! pivot `c` in the target frame, `y ↦ y + t + r × (y − c) + S (y − c)`, in the order
//! `[tx ty tz rx ry rz]`, then `scale` or `scale_x … shear_yz`; with `c` at the origin the first
//! six are the `ξ` of `T = exp(ξ) T̂`.
//!
//! Sources: Kabsch (1976) and Umeyama (1991) for the closed form, Baarda (1968) for data snooping;
//! documents \[A\] (equation 1.14, the planar frame of a force sensor), \[B\] (step S3, the
//! frame of a laser tracker) and \[D\] (equation 6).
//!
//! ```
//! use frame_fit::{Options, PointPair, Transform, compare_transforms, fit_frame};
//! use frame_fit::nalgebra::{Isometry3, Point3, Vector3};
//!
//! let truth = Isometry3::new(Vector3::new(10.0, -5.0, 2.0), Vector3::z() * 0.1);
//! let corners = [
//!     [0.0, 0.0, 0.0],
//!     [100.0, 0.0, 0.0],
//!     [0.0, 80.0, 0.0],
//!     [0.0, 0.0, 60.0],
//!     [100.0, 80.0, 60.0],
//! ];
//! let pairs = corners.map(|c| {
//!     let source = Point3::from(c);
//!     PointPair::isotropic(source, truth * source, 0.01)
//! });
//!
//! let fit = fit_frame(&pairs, &Options::default())?;
//! let pose = fit.target_from_source.isometry().expect("a rigid fit is a pose");
//! assert!((pose.inverse() * truth).translation.vector.norm() < 1e-10);
//! assert_eq!(fit.degrees_of_freedom, 9);
//!
//! // The rigid family is needed, and enough.
//! let tests = compare_transforms(&pairs, &Options::default())?;
//! let needed = tests.iter().rev().find(|t| t.p_value < 0.01).map(|t| t.larger);
//! assert_eq!(needed, Some(Transform::Rigid));
//! # Ok::<(), frame_fit::FrameFitError>(())
//! ```

// What public items are made of.
pub use least_squares;
#[cfg(feature = "loop")]
pub use model_discrepancy;
pub use nalgebra;

mod closed_form;
mod decompose;
mod error;
mod fit;
mod input;
mod map;
mod mislabelled;
#[cfg(feature = "loop")]
mod missing;
mod motion;
mod nested;
mod options;
mod pair;
mod problem;
mod refine;
mod reflection;
mod shape;
mod snooping;
mod spread;
mod statistics;
mod tip;
mod transform;
mod uncertainty;

pub use error::{FrameFitError, FreeMotion, InvalidPair};
pub use fit::{FrameFit, fit_frame};
pub use map::FrameMap;
pub use mislabelled::{Mislabelled, mislabelled};
#[cfg(feature = "loop")]
pub use missing::{FrameModel, MapWithEffects, MeasuredPoint, NearestSimilarity, TipModel};
pub use nested::{NestedTest, compare_transforms};
pub use options::{Noise, Options};
pub use pair::{PointPair, Uncertainty};
pub use reflection::{Reflection, ReflectionVerdict};
pub use shape::{Shape, shape_of};
pub use snooping::{Reliability, Snooping, SnoopingOptions, Suspect, reliability, snoop};
pub use tip::{KnownDistance, TipFit, TipPose, fit_tip};
pub use transform::{Handedness, Transform};
pub use uncertainty::FrameParameter;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
