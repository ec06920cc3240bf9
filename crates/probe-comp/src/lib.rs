//! From ball centres to the surface that was really touched.
//!
//! [`compensate`] turns what a touch probe reads, the centre of its ball, into the contact
//! A' = O' − r n', its deviation from the nominal surface along the surface's normal, and the
//! uncertainty of both. The normal is the nominal one, the approach, or one that is measured by
//! touching around the place ([`NormalSource`]); [`micro_radius`] says how far around.
//! [`compensate_profile`] does the same for a profile that is scanned in a plane, [`guide_point`] says where a
//! ball is to be sent.
//! [`qualify`] finds what a probe adds from touches of a reference sphere or ring, and takes it off
//! later ones. [`ProbeModel`] lets `model_discrepancy` find what the probe, the machine or the part add.
//!
//! Lengths are in mm, angles in rad, everything in the frame of the workpiece. Normals point from
//! the part to the ball, deviations are positive where the part is too large, curvatures where it
//! is hollow.
//!
//! Source: document \[E\].
//!
//! ```
//! use std::sync::Arc;
//!
//! use probe_comp::geometry::{Asphere, AsphereShape};
//! use probe_comp::nalgebra::{Point3, Vector3};
//! use probe_comp::{BallTouch, Nominal, NormalSource, Side, compensate};
//!
//! // A paraboloid bowl, R = 120 mm, is 0.004 mm too high where a ball of radius 3 mm touches it.
//! let bowl = Asphere::new(AsphereShape::on_axis(120.0, -1.0, vec![], 100.0))?;
//! let nominal = Nominal::new(Arc::new(bowl), Side::Along);
//! let on = Point3::new(30.0, 40.0, 2500.0 / 240.0);
//! let normal = Vector3::new(-30.0 / 120.0, -40.0 / 120.0, 1.0).normalize();
//! let touch = BallTouch::new(on + normal * 3.004, 0.001);
//!
//! let contact = &compensate(&nominal, 3.0, &[touch], NormalSource::Nominal)?[0];
//! assert!((contact.deviation_mm - 0.004).abs() < 1e-12);
//! assert!((contact.point_mm - (on + normal * 0.004)).norm() < 1e-12);
//! assert!((contact.sigma_deviation_mm() - 0.001).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![cfg_attr(
    not(feature = "loop"),
    expect(dead_code, reason = "the model of the loop asks for more of the shared parts")
)]

// One touch after the other.
mod compensate;
mod contact;
mod error;
mod foot;
mod guide;
mod micro_radius;
mod nearest;
mod neighbours;
mod nominal;
mod profile;
mod touch;

// All of them together.
#[cfg(feature = "loop")]
mod missing;
mod qualify;

// What public items are made of.
pub use geometry;
pub use least_squares;
#[cfg(feature = "loop")]
pub use model_discrepancy;
pub use nalgebra;

pub use compensate::{NormalSource, compensate};
pub use contact::{Contact, PlannedContact};
pub use error::{InvalidTouch, ProbeError};
pub use guide::{GuidePoint, guide_point};
pub use micro_radius::{MicroRadius, micro_radius};
#[cfg(feature = "loop")]
pub use missing::{ContactChange, MeasuredTouch, ProbeModel, ProbeSetup};
pub use nominal::{Nominal, NominalFoot, Side};
pub use profile::{ProfileContact, compensate_profile};
pub use qualify::{Lobe, ProbeTerms, ProbeUncertainty, Qualification, Reference, qualify};
pub use touch::BallTouch;

/// Runs the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
