//! C interface of `force-impedance`: what C, C++, LinuxCNC and PLC runtimes call.
//!
//! `include/force_impedance.h` is this file for a C compiler. Frame, units and signs are those of
//! `force-impedance`: frame Y with the straight tool along −y, mm, N, rad, s, compression positive,
//! legs in the order `l1, l2, l3` (radial), `l4` (axial).
//!
//! - The caller provides all storage ([`FiHead`], [`FiController`]); nothing is allocated, nothing
//!   has to be freed, and copying the storage copies what is in it.
//! - Every function returns an [`FiError`]; null and misaligned pointers and storage that was not
//!   initialised are errors, not undefined behaviour. On an error outputs are left alone, but
//!   storage whose initialisation is refused holds nothing.
//! - Inputs are copied before outputs are written: they may overlap. A command within the storage of
//!   its controller is refused.
//! - Nothing unwinds: an `extern "C"` function would abort, and none of those in a control cycle
//!   can panic (`cargo xtask realtime` proves it of the whole interface without `std`).
//! - A handle belongs to one thread at a time.
//!
//! ```
//! use force_impedance_c::*;
//! use std::mem::zeroed;
//!
//! // SAFETY: all are plain numbers, and the pointers are to live locals.
//! unsafe {
//!     let geometry = FiHeadGeometry {
//!         tip_to_plane_mm: 120.0,
//!         plane_to_joint_mm: 180.0,
//!         head_radius_mm: 40.0,
//!         bracket_radius_mm: 110.0,
//!         leg_angles_rad: [90.0_f64, 210.0, 330.0].map(f64::to_radians),
//!         weight_n: 60.0,
//!         center_of_gravity_mm: 150.0,
//!         gravity_direction: [0.0, 0.0, -1.0],
//!     };
//!     let (mut head, mut pose): (FiHead, FiPose) = (zeroed(), zeroed());
//!     assert_eq!(fi_head_init(&mut head, &geometry, std::ptr::null()), FiError::None);
//!     let tip_mm = [4.0, -301.5, -2.5];
//!     assert_eq!(fi_head_inverse(&head, tip_mm.as_ptr(), &mut pose), FiError::None);
//!     assert_eq!(pose.tip_mm, tip_mm);
//! }
//! ```
// A library that unwinds needs the standard library, whatever its features.
#![cfg_attr(all(not(feature = "std"), panic = "abort"), no_std)]
#![deny(unsafe_op_in_unsafe_fn)]
#![expect(unsafe_code, reason = "a C interface takes pointers; the checks are in pointer.rs")]

mod command;
mod contact;
mod controller;
mod error;
#[cfg(feature = "std")]
mod explain;
mod head;
#[cfg(all(not(feature = "std"), panic = "abort", not(test)))]
mod panic;
mod pointer;
mod settings;

pub use command::{FiCommand, FiFault, FiLimit, FiMeasurement, FiStatus};
pub use contact::{FiContact, fi_head_contact, fi_head_published_normal};
pub use controller::{
    FiController, fi_controller_init, fi_controller_set_impedance, fi_controller_set_mode,
    fi_controller_update,
};
pub use error::{FiError, fi_error_text};
#[cfg(feature = "std")]
pub use explain::fi_explain;
pub use head::{
    FiHead, FiHeadGeometry, FiHeadLimits, FiPose, fi_head_forward, fi_head_init, fi_head_inverse,
    fi_head_jacobian, fi_head_limits_wide, fi_head_start,
};
pub use settings::{FiDiscretisation, FiImpedance, FiMode, FiSettings, fi_settings_default};
