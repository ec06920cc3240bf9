use nalgebra::Point3;

use super::boxes::Aabb;
use super::build::{leaf_start, n_leaves, spatial_order};
use super::wide::Nodes;

/// A k-d tree over points; everything but `order` is in the tree's own order of slots.
#[derive(Clone, Debug)]
pub(crate) struct KdTree {
    pub(super) points: Vec<Point3<f64>>,
    /// The same from the corner of all, in single precision.
    pub(super) single: Vec<[f32; 3]>,
    /// The largest coordinate of these.
    pub(super) extent_mm: f64,
    /// Place of each slot's point in the input.
    order: Vec<u32>,
    pub(super) nodes: Nodes,
    n_leaves: usize,
}

impl KdTree {
    pub(crate) fn new(points: &[Point3<f64>]) -> Self {
        let (points, order) = spatial_order(points);
        let n_leaves = n_leaves(points.len());
        let nodes = Nodes::over(&points, n_leaves);
        let corner = nodes.corner;
        let mut extent_mm = 0.0;
        let mut single = |p: &Point3<f64>| {
            let from_corner = |k: usize| {
                let value = p[k] - corner[k];
                extent_mm = if value > extent_mm { value } else { extent_mm };
                #[expect(clippy::cast_possible_truncation, reason = "whose error is looked at")]
                let value = value as f32;
                value
            };
            [0, 1, 2].map(from_corner)
        };
        let single = points.iter().map(&mut single).collect();
        Self { points, single, extent_mm, order, nodes, n_leaves }
    }

    pub(crate) fn points(&self) -> &[Point3<f64>] {
        &self.points
    }

    pub(crate) fn n_leaves(&self) -> usize {
        self.n_leaves
    }

    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    /// Values given in input order, in the order of the slots.
    pub(crate) fn in_slots<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.order.iter().map(|&i| values[i as usize]).collect()
    }

    /// Slots of a leaf.
    #[expect(clippy::inline_always, reason = "inlined into what is compiled for wide registers")]
    #[inline(always)]
    pub(crate) fn leaf(&self, leaf: usize) -> std::ops::Range<usize> {
        leaf_start(leaf, self.n_leaves, self.points.len())
            ..leaf_start(leaf + 1, self.n_leaves, self.points.len())
    }

    /// For each slot, how far the few points of its leaf extend.
    pub(crate) fn leaf_reaches(&self) -> Vec<f32> {
        let mut reaches = vec![0.0; self.points.len()];
        for leaf in 0..self.n_leaves {
            let slots = self.leaf(leaf);
            #[expect(clippy::cast_possible_truncation, reason = "a bound on a test, not a result")]
            let reach = Aabb::of(&self.points[slots.clone()]).extent().norm() as f32;
            reaches[slots].fill(reach);
        }
        reaches
    }
}
