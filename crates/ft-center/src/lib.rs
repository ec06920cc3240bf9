//! Where a polishing head really presses, from a six-axis force/torque sensor.
//!
//! - [`center_of_pressure`] solves one wrench, [`solve_orbit`] the record of a spinning, wobbling
//!   head: centre of the orbit with its covariance under coloured noise, spin and wobble.
//! - [`fit_sensor_frame`] places the sensor in the machine by presses at known positions, mirrored
//!   where the z axes oppose each other; [`fit_affine_frame`] shows scale and shear.
//! - [`locate`] puts presses together: found − commanded position is the offset to compensate.
//! - [`SavedFrame`] keeps a frame, and [`locate_in`] locates any head in it from then on;
//!   [`repeatability`] says how well a head comes back.
//! - [`contact_on_surface`] finds the contact on a curved workpiece on top of the sensor,
//!   [`Monitor`] follows it live without allocating, [`solve_batch`] reads millions of samples once.
//! - [`axis_figures`] gives accuracy and repeatability of a linear or rotary axis by ISO 230-2.
//! - With the feature `loop`, on by default, `PressModel`, `DisplacementModel`, `GravityModel` and
//!   `positioning_model` are these measurements as models for the loop of `model_discrepancy`,
//!   with the effects that they may lack.
//!
//! A wrench acts *on* the sensor, its moment is about the sensor's reference point: `M = p × F`.
//! Lengths are in mm, forces in N, moments in N·mm, angles in rad, times in s. The normal force of
//! a press may have either sign, but one sign throughout a record.
//!
//! Source: \[A\], a patent on locating polishing heads by a force sensor, with the numbers of its
//! equations; `docs/ft-center.md` in the repository lists what it gets wrong.
//!
//! ```
//! use ft_center::center_of_pressure;
//! use ft_center::geometry::Wrench;
//! use ft_center::nalgebra::{Point3, Vector3};
//!
//! // 40 N down and 3 N sideways at (12, −7) on a platform 30 mm high, and a pad's friction couple.
//! let at = Point3::new(12.0, -7.0, 30.0);
//! let mut wrench = Wrench::of_force(Vector3::new(3.0, 0.0, -40.0), &at);
//! wrench.torque_nmm.z += 150.0;
//!
//! let found = center_of_pressure(&wrench, 30.0, 5.0)?;
//! assert!((found.position_mm - at.xy()).norm() < 1e-12);
//! assert!((found.free_moment_nmm - 150.0).abs() < 1e-10);
//! # Ok::<(), ft_center::FtCenterError>(())
//! ```

// What public items are made of.
pub use geometry;
pub use least_squares;
#[cfg(feature = "loop")]
pub use model_discrepancy;
pub use nalgebra;

mod affine;
mod axis_figures;
mod axis_reading;
mod batch;
mod centroid;
mod colour;
mod commanded_frame;
mod error;
mod frame;
mod frame_point;
mod gate;
mod gravity;
mod harmonic;
mod locate;
#[cfg(feature = "loop")]
mod missing;
mod monitor;
mod orbit;
mod press;
mod press_noise;
mod pressure;
mod repeatability;
mod sample;
mod saved_frame;
mod spectrum;
mod surface_contact;

pub use affine::{AffineFrame, fit_affine_frame};
pub use axis_figures::{AxisFigures, Figure, OneWay, TargetFigures, axis_figures};
pub use axis_reading::{Approach, AxisMotion, AxisReading};
pub use batch::{BatchCenter, WrenchArrays, centers_into, solve_batch};
pub use centroid::{pressure_centroid_mm, removal_centroid_mm};
pub use commanded_frame::CommandedFrame;
pub use error::{FtCenterError, Table};
pub use frame::{Handedness, HandednessSource, SensorFrame, fit_sensor_frame};
pub use frame_point::FramePoint;
pub use gravity::{GravityCalibration, GravityOptions, StaticPose, calibrate_gravity};
pub use locate::{Center, LocateOptions, Located, locate};
#[cfg(feature = "loop")]
pub use missing::{
    AxisRun, AxisTerm, Displacement, DisplacementModel, GravityModel, PressModel, axis_coordinates,
    positioning_model,
};
pub use monitor::{ContactStatus, Monitor, MonitorOptions, MonitorReading, Platform};
pub use orbit::{Orbit, OrbitOptions, Wobble, solve_orbit};
pub use press::{Press, PressRole, SolvedPress, solve_presses};
pub use pressure::{PressurePoint, center_of_pressure};
pub use repeatability::{Repeatability, repeatability};
pub use sample::{Contact, Noise, Sample};
pub use saved_frame::{SavedFrame, locate_in};
pub use surface_contact::{CoupleAxis, SurfaceContact, contact_on_surface};

/// A count as a number; exact below 2⁵³.
#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn count(n: usize) -> f64 {
    n as f64
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
