//! Balanced k-d tree whose leaves lie one after the other in memory.
//!
//! Queries come in groups of [`LANES`] neighbours: the tree is walked once for a group, and each
//! point of a leaf is compared with all of its queries at once.

mod boxes;
mod build;
mod group;
mod nearest;

use nalgebra::Point3;

pub(crate) use boxes::Aabb;
pub(crate) use build::{LANES, spatial_order};
pub(crate) use group::{Found, NONE};

/// A k-d tree over points; everything but `order` is in the tree's own order of slots.
#[derive(Clone, Debug)]
pub(crate) struct KdTree {
    points: Vec<Point3<f64>>,
    /// Place of each slot's point in the input.
    order: Vec<u32>,
    /// Heap of `2 × leaves` boxes; entry 0 is unused, entry 1 the root.
    boxes: Vec<Aabb>,
    n_leaves: usize,
}

impl KdTree {
    pub(crate) fn new(points: &[Point3<f64>]) -> Self {
        let (points, order) = spatial_order(points);
        let n_leaves = build::n_leaves(points.len());
        let boxes = boxes::heap(&points, n_leaves);
        Self { points, order, boxes, n_leaves }
    }

    pub(crate) fn points(&self) -> &[Point3<f64>] {
        &self.points
    }

    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    /// Values given in input order, in the order of the slots.
    pub(crate) fn in_slots<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.order.iter().map(|&i| values[i as usize]).collect()
    }

    fn leaf(&self, leaf: usize) -> std::ops::Range<usize> {
        build::leaf_start(leaf, self.n_leaves, self.points.len())
            ..build::leaf_start(leaf + 1, self.n_leaves, self.points.len())
    }

    /// For each slot, how far the few points of its leaf extend.
    pub(crate) fn leaf_reaches(&self) -> Vec<f32> {
        let mut reaches = vec![0.0; self.points.len()];
        for leaf in 0..self.n_leaves {
            #[expect(clippy::cast_possible_truncation, reason = "a bound on a test, not a result")]
            let reach = self.boxes[self.n_leaves + leaf].extent().norm() as f32;
            reaches[self.leaf(leaf)].fill(reach);
        }
        reaches
    }
}
