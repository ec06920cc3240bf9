//! Where a polishing head really presses, from a six-axis force/torque sensor.

mod displacement_model;
mod error;
mod frame;
mod gravity;
mod gravity_model;
mod locate;
mod orbit;
mod press;
mod press_model;
mod pressure;
mod sample;

pub use displacement_model::{Displacement, DisplacementModel};
pub use error::{FtCenterError, Table};
pub use frame::{
    AffineFrame, FramePoint, Handedness, HandednessSource, SensorFrame, fit_affine_frame,
    fit_sensor_frame,
};
pub use gravity::{GravityCalibration, GravityOptions, StaticPose, calibrate_gravity};
pub use gravity_model::GravityModel;
pub use locate::{Center, LocateOptions, Located, locate};
pub use orbit::{Orbit, OrbitOptions, Wobble, solve_orbit};
pub use press::{Press, PressRole, SolvedPress, solve_presses};
pub use press_model::PressModel;
pub use pressure::{PressurePoint, center_of_pressure};
pub use sample::{Contact, Noise, Sample};
