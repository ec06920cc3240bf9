//! Numbers as a list of faces shows them.

use std::fmt;

use geometry::nalgebra::Vector3;

/// Three numbers, to a thousandth.
pub(super) struct Shown<'v>(pub(super) &'v Vector3<f64>);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = [self.0.x, self.0.y, self.0.z].map(rounded);
        write!(f, "({x}, {y}, {z})")
    }
}

/// To a thousandth, without the sign of a zero.
pub(super) fn rounded(value: f64) -> f64 {
    (value * 1e3).round() / 1e3 + 0.0
}
