//! Where a polishing head really presses, from a six-axis force/torque sensor.

mod affine;
mod batch;
mod centroid;
mod colour;
mod displacement_model;
mod error;
mod frame;
mod frame_point;
mod gate;
mod gravity;
mod gravity_effects;
mod gravity_model;
mod harmonic;
mod locate;
mod monitor;
mod orbit;
mod parameter;
mod press;
mod press_design;
mod press_effects;
mod press_located;
mod press_model;
mod press_noise;
mod press_proposals;
mod pressure;
mod sample;
mod sensor_errors;
mod spectrum;
mod surface_contact;

pub use affine::{AffineFrame, fit_affine_frame};
pub use batch::{BatchCenter, WrenchArrays, centers_into, solve_batch};
pub use centroid::{pressure_centroid_mm, removal_centroid_mm};
pub use displacement_model::{Displacement, DisplacementModel};
pub use error::{FtCenterError, Table};
pub use frame::{Handedness, HandednessSource, SensorFrame, fit_sensor_frame};
pub use frame_point::FramePoint;
pub use gravity::{GravityCalibration, GravityOptions, StaticPose, calibrate_gravity};
pub use gravity_model::GravityModel;
pub use locate::{Center, LocateOptions, Located, locate};
pub use monitor::{ContactStatus, Monitor, MonitorOptions, MonitorReading, Platform};
pub use orbit::{Orbit, OrbitOptions, Wobble, solve_orbit};
pub use press::{Press, PressRole, SolvedPress, solve_presses};
pub use press_model::PressModel;
pub use pressure::{PressurePoint, center_of_pressure};
pub use sample::{Contact, Noise, Sample};
pub use surface_contact::{CoupleAxis, SurfaceContact, contact_on_surface};

/// A count as a number; exact below 2⁵³.
#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
fn count(n: usize) -> f64 {
    n as f64
}
