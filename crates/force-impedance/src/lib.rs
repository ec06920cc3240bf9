//! Contact force and position impedance of a polishing head on four legs.
//!
//! A polishing spindle hangs on three radial legs and one axial unit, each with a displacement
//! sensor, a load cell and a cylinder. [`Head`] knows its kinematics, [`Balance`] turns four
//! load-cell readings into the contact force, friction included; [`Controller`] turns the force
//! error into lengths to command, every cycle, and cannot fail.
//!
//! The impedance `M·E'' + D·E' + K·E = F_n − F_r` moves the tool by `E` along the surface normal.
//!
//! Frame Y: origin in the joint `O_Y`, the straight tool along −y. Legs and cells are in the
//! order of `l1, l2, l3` (radial) and `l4` (axial). Cells read compression positive; the contact
//! force acts *on the tool*, normals point out of the workpiece, so that pressing is positive.
//! Lengths are in mm, forces in N, angles in rad, times in s.
//!
//! Without the feature `std` (on by default) the crate is `no_std` and allocates nothing.
//!
//! Source: \[C\], a patent on a polishing tool that couples force and position;
//! `docs/force-impedance.md` in the repository has the equations and what it gets wrong.
//!
//! ```
//! use force_impedance::{Head, HeadGeometry, HeadLimits};
//! use force_impedance::nalgebra::{Point3, Vector3};
//!
//! let geometry = HeadGeometry {
//!     tip_to_plane_mm: 120.0,
//!     plane_to_joint_mm: 180.0,
//!     head_radius_mm: 40.0,
//!     bracket_radius_mm: 110.0,
//!     leg_angles_rad: [90.0_f64, 210.0, 330.0].map(f64::to_radians),
//!     weight_n: 60.0,
//!     center_of_gravity_mm: 150.0,
//!     gravity_direction: -Vector3::z(),
//! };
//! let head = Head::new(geometry, HeadLimits::wide(&geometry))?;
//!
//! // Inverse kinematics, and back.
//! let tip_mm = Point3::new(4.0, -301.5, -2.5);
//! let pose = head.pose_at(&tip_mm)?;
//! let found = head.pose_of_lengths(&pose.lengths_mm)?;
//! assert!((found.pose.tip_mm - tip_mm).norm() < 1e-11);
//! assert!(found.consistency_mm.abs() < 1e-12);
//!
//! // Contact force from four load cells, split along the surface normal.
//! let normal = Vector3::new(0.1, 1.0, 0.0).normalize();
//! let contact = head.balance(&pose).contact(&[22.0, 51.0, 49.0, 81.0], &normal);
//! assert!(contact.normal_n > 70.0 && contact.friction_ratio.is_some());
//! # Ok::<(), force_impedance::ForceImpedanceError>(())
//! ```
#![cfg_attr(not(feature = "std"), no_std)]

// What public items are made of.
#[cfg(feature = "loop")]
pub use model_discrepancy;
pub use nalgebra;

mod balance;
mod chain;
mod cofactor;
mod command;
#[cfg(feature = "std")]
mod contact_loop;
mod controller;
#[cfg(feature = "std")]
mod design;
mod discretise;
mod error;
mod forward;
mod head;
mod impedance;
mod impedance_parameters;
#[cfg(feature = "std")]
mod log;
#[cfg(feature = "loop")]
mod missing;
mod motion;
mod pose;
mod ramp;
mod redundancy;
mod scalar;
mod settings;
mod steering;
mod warning;
mod watch;
mod workspace;

pub use balance::{Balance, ContactForce};
pub use chain::MachineChain;
pub use command::{Cells, Command, Fault, Limits, Measurement, Status};
#[cfg(feature = "std")]
pub use contact_loop::LoopSettings;
pub use controller::Controller;
#[cfg(feature = "std")]
pub use design::{DesignPoint, Margins, Recommendation, design_point, margins_at, recommend};
pub use error::ForceImpedanceError;
pub use forward::ForwardPose;
pub use head::{Head, HeadGeometry, HeadLimits};
pub use impedance::{Discretisation, Impedance};
pub use impedance_parameters::ImpedanceParameters;
#[cfg(feature = "std")]
pub use log::{ForceFormula, LogSample, LoggedForce, solve_log};
#[cfg(feature = "loop")]
pub use missing::{LogModel, LogOptions, PathModel, PathOptions, PathSample};
pub use pose::HeadPose;
pub use settings::{ControllerSettings, ReferenceMode};
pub use warning::{Warning, WarningLimits, warnings};

/// A count as a number; exact below 2⁵³.
#[cfg(feature = "std")]
#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn count(n: usize) -> f64 {
    n as f64
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
