//! Six errors of a rotary axis from laser-tracer displacements, by multilateration.
//!
//! A tracer at stations Sᵢ follows reflectors tⱼ on the axis through steps k and reads how far
//! its path has changed since it locked on. [`calibrate`] minimises `Σ u²/σ²` over
//! `u = |o + e + exp(ω)·Rot(b)·t − S| − (l + L)`: stations, dead paths l, reflectors and the six
//! errors `[e, ω]` of every angle at once ([`Formulation::Joint`]); or over free target points
//! with rigid-body rows, from which the errors follow angle by angle
//! ([`Formulation::FreePoints`]).
//!
//! Lengths are in mm, angles in rad. The errors are `[EX EY EZ EA EB EC]` of the nominal axis'
//! origin, relative to the first angle measured, in the machine frame (or the frame that turns
//! with the axis, [`ErrorOrder`]): the point that should be at `o + q` is at `o + e + exp(ω)·q`.
//!
//! Trackers that give points, each in the frame of its station, are bundled by
//! [`calibrate_targets`]; one station is then enough.
//!
//! What the six errors do to a point, a tool's tip, is their first-order map ([`error_map`], [`point_errors`]).
//!
//! Source: document \[B\], steps S1 to S4; ISO 230-1 and 230-7 for names and frames; Theil (1965)
//! for the residuals that the loop looks at.
//!
//! ```
//! use tracker_lm::nalgebra::Vector3;
//! use tracker_lm::error_at_angle;
//!
//! // Three reflectors about the axis' origin; the body has moved 3 µm along x and turned 10 µrad
//! // about z.
//! let arms_mm = [[150.0, 0.0, 20.0], [0.0, 120.0, -30.0], [-80.0, -90.0, 0.0]].map(Vector3::from);
//! let moved = arms_mm.map(|q| Vector3::new(0.003, 0.0, 0.0) + Vector3::z().cross(&q) * 10e-6);
//! let (error, _) = error_at_angle(&arms_mm, &moved).expect("three points span a plane");
//! assert!((error[0] - 0.003).abs() < 1e-6 && (error[5] - 10e-6).abs() < 1e-8);
//! ```

#![cfg_attr(
    not(feature = "loop"),
    expect(dead_code, reason = "the model of the loop asks for more of the shared parts")
)]

// What public items are made of.
pub use least_squares;
#[cfg(feature = "loop")]
pub use model_discrepancy;
pub use nalgebra;

mod angle_spread;
mod angle_steps;
mod axes;
mod axis;
mod calibrate;
mod calibration;
mod count;
mod curves;
mod error;
mod error_order;
mod export;
mod find_axis;
mod first_order;
mod frame;
mod free_points;
mod gauge;
mod head;
mod joint;
mod joint_result;
mod kinds;
mod lists;
mod location;
#[cfg(feature = "loop")]
mod missing;
mod motion;
mod network;
mod options;
mod perfect;
mod points_result;
mod readings;
#[cfg(feature = "loop")]
mod recorded;
mod search;
mod shift;
mod spread;
mod start;
mod survey;
mod targets;
mod weights;

pub use axes::AxesRelation;
pub use axis::{AxisLetter, RotaryAxis};
pub use calibrate::calibrate;
pub use calibration::{
    AxisError, Calibration, DeadPathEstimate, MountEstimate, SecondCalibration, StationEstimate,
};
pub use error::{Record, Shortage, TrackerError};
pub use export::{axis_errors_csv, heidenhain_table, linuxcnc_compensation};
pub use find_axis::{Sought, find_axis};
pub use first_order::{PointError, error_map, fixed_frame_error, point_errors, point_errors_csv};
pub use location::AxisLocation;
#[cfg(feature = "loop")]
pub use missing::TrackerModel;
pub use motion::error_at_angle;
pub use options::{AxisModel, DeadPath, ErrorOrder, Formulation, Gauge, Noise, Options};
pub use survey::{Approach, Mount, Range, SecondAxis, Station, Step, Survey};
#[cfg(feature = "loop")]
pub use targets::{HoldOut, TargetModel, TargetRecords};
pub use targets::{
    StationPose, Target, TargetCalibration, TargetNoise, TargetOptions, TargetSurvey,
    calibrate_targets,
};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
