//! Where effects of known size put the geometry of a range.

use nalgebra::{Vector3, Vector6};

/// How far the parts of one range are from where the parameters have them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Shift {
    /// Displacement in mm, rotation in rad.
    pub(crate) error: Vector6<f64>,
    pub(crate) station_mm: Vector3<f64>,
    pub(crate) mount_mm: Vector3<f64>,
}
