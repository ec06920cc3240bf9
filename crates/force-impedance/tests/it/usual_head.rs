//! The head that tests and benches share.

use std::f64::consts::TAU;

use force_impedance::{Head, HeadGeometry, HeadLimits};
use nalgebra::Vector3;

pub(crate) const GEOMETRY: HeadGeometry = HeadGeometry {
    tip_to_plane_mm: 120.0,
    plane_to_joint_mm: 180.0,
    head_radius_mm: 40.0,
    bracket_radius_mm: 110.0,
    leg_angles_rad: [TAU / 4.0, TAU * 7.0 / 12.0, TAU * 11.0 / 12.0],
    weight_n: 85.0,
    center_of_gravity_mm: 140.0,
    gravity_direction: Vector3::new(0.0, 0.0, -1.0),
};

pub(crate) fn head() -> Head {
    Head::new(GEOMETRY, HeadLimits::wide(&GEOMETRY)).unwrap()
}
