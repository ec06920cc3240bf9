#![expect(
    clippy::inline_always,
    reason = "inlined into functions that are compiled for wide registers"
)]

use nalgebra::{Point3, Vector3};

use crate::outwards::{above, below};

/// Axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Aabb {
    pub(crate) min: [f64; 3],
    pub(crate) max: [f64; 3],
}

impl Aabb {
    const EMPTY: Self = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    #[inline(always)]
    pub(crate) fn of(points: &[Point3<f64>]) -> Self {
        let mut aabb = Self::EMPTY;
        for p in points {
            for k in 0..3 {
                aabb.min[k] = if p[k] < aabb.min[k] { p[k] } else { aabb.min[k] };
                aabb.max[k] = if p[k] > aabb.max[k] { p[k] } else { aabb.max[k] };
            }
        }
        aabb
    }

    pub(crate) fn extent(&self) -> Vector3<f64> {
        Vector3::from_fn(|k, _| self.max[k] - self.min[k])
    }
}

/// Axis-aligned box in single precision, rounded outwards, from the corner of all points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OuterBox {
    pub(super) min: [f32; 3],
    pub(super) max: [f32; 3],
}

impl OuterBox {
    #[inline(always)]
    pub(super) fn of(aabb: &Aabb, corner: &[f64; 3]) -> Self {
        Self {
            min: std::array::from_fn(|k| below(aabb.min[k] - corner[k])),
            max: std::array::from_fn(|k| above(aabb.max[k] - corner[k])),
        }
    }

    #[inline(always)]
    pub(super) fn center(&self) -> [f32; 3] {
        std::array::from_fn(|k| 0.5 * self.min[k] + 0.5 * self.max[k])
    }
}
