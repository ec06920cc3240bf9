#![expect(
    clippy::inline_always,
    reason = "inlined into functions that are compiled for wide registers"
)]

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use super::build::leaf_start;

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
                aabb.min[k] = aabb.min[k].min(p[k]);
                aabb.max[k] = aabb.max[k].max(p[k]);
            }
        }
        aabb
    }

    fn union(&self, other: &Self) -> Self {
        Self {
            min: std::array::from_fn(|k| self.min[k].min(other.min[k])),
            max: std::array::from_fn(|k| self.max[k].max(other.max[k])),
        }
    }

    /// Smallest squared distance between a point of this box and a point of the other.
    #[inline(always)]
    pub(crate) fn gap_squared(&self, other: &Self) -> f64 {
        let mut sum = 0.0;
        for k in 0..3 {
            let (above, below) = (self.min[k] - other.max[k], other.min[k] - self.max[k]);
            // At most one is positive.
            let gap = if above > below { above } else { below };
            let gap = if gap > 0.0 { gap } else { 0.0 };
            sum += gap * gap;
        }
        sum
    }

    pub(crate) fn extent(&self) -> Vector3<f64> {
        Vector3::from_fn(|k, _| self.max[k] - self.min[k])
    }

    pub(crate) fn center(&self) -> Point3<f64> {
        Point3::from(Vector3::from_fn(|k, _| 0.5 * (self.min[k] + self.max[k])))
    }
}

/// Boxes of the leaves and of everything above them, as a heap.
pub(super) fn heap(points: &[Point3<f64>], n_leaves: usize) -> Vec<Aabb> {
    let mut boxes = vec![Aabb::EMPTY; 2 * n_leaves];
    boxes[n_leaves..].par_iter_mut().with_min_len(1024).enumerate().for_each(|(leaf, aabb)| {
        let range =
            leaf_start(leaf, n_leaves, points.len())..leaf_start(leaf + 1, n_leaves, points.len());
        *aabb = Aabb::of(&points[range]);
    });
    for node in (1..n_leaves).rev() {
        boxes[node] = boxes[2 * node].union(&boxes[2 * node + 1]);
    }
    boxes
}
