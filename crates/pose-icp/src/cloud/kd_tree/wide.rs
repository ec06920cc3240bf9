//! Boxes above the leaves, eight to a node.

#![expect(
    clippy::inline_always,
    reason = "inlined into functions that are compiled for wide registers"
)]

use nalgebra::Point3;
use rayon::prelude::*;

use super::boxes::{Aabb, OuterBox};
use super::build::leaf_start;

/// Children of a node, and values that one register of `f32` holds.
pub(crate) const WIDTH: usize = 8;

/// Levels of a binary tree in one of this.
const BITS: u32 = 3;

/// Nodes that one thread makes at once, at least.
const NODES_AT_ONCE: usize = 256;

/// Bound on the relative rounding of a squared gap in single precision.
const ROUNDED_DOWN: f32 = 1.0 - 1e-6;

/// Boxes of the children of a node; a child that is not there is a box turned inside out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    min: [[f32; WIDTH]; 3],
    max: [[f32; WIDTH]; 3],
}

impl Node {
    const EMPTY: Self =
        Self { min: [[f32::INFINITY; WIDTH]; 3], max: [[f32::NEG_INFINITY; WIDTH]; 3] };

    fn set(&mut self, child: usize, aabb: &OuterBox) {
        for k in 0..3 {
            self.min[k][child] = aabb.min[k];
            self.max[k][child] = aabb.max[k];
        }
    }

    /// Box around all children.
    fn all(&self) -> OuterBox {
        OuterBox {
            min: self.min.map(|v| v.into_iter().fold(f32::INFINITY, f32::min)),
            max: self.max.map(|v| v.into_iter().fold(f32::NEG_INFINITY, f32::max)),
        }
    }

    pub(super) fn child(&self, child: usize) -> OuterBox {
        OuterBox {
            min: std::array::from_fn(|k| self.min[k][child]),
            max: std::array::from_fn(|k| self.max[k][child]),
        }
    }

    /// Squared distances of the children from a box, rounded down; infinite for none.
    #[inline(always)]
    pub(super) fn gaps_squared(&self, aabb: &OuterBox) -> [f32; WIDTH] {
        let mut sums = [0.0_f32; WIDTH];
        for k in 0..3 {
            let (low, high) = (aabb.min[k], aabb.max[k]);
            for (lane, sum) in sums.iter_mut().enumerate() {
                let (above, below) = (self.min[k][lane] - high, low - self.max[k][lane]);
                // At most one is positive.
                let gap = if above > below { above } else { below };
                let gap = if gap > 0.0 { gap } else { 0.0 };
                *sum += gap * gap;
            }
        }
        for sum in &mut sums {
            *sum *= ROUNDED_DOWN;
        }
        sums
    }
}

/// All nodes, level by level from the root; those of a level in the order of their leaves.
#[derive(Clone, Debug)]
pub(super) struct Nodes {
    all: Vec<Node>,
    /// Where each level begins.
    starts: Vec<usize>,
    /// Binary levels that each child of the root lies below it.
    root_bits: u32,
    /// Corner that the boxes are measured from.
    pub(super) corner: [f64; 3],
}

impl Nodes {
    pub(super) fn over(points: &[Point3<f64>], n_leaves: usize) -> Self {
        let height = n_leaves.trailing_zeros();
        let n_levels = height.div_ceil(BITS).max(1);
        let root_bits = height - BITS * (n_levels - 1);
        let mut starts = vec![0, 1];
        for level in 1..n_levels {
            let n_nodes = 1_usize << (root_bits + BITS * (level - 1));
            starts.push(starts[starts.len() - 1] + n_nodes);
        }
        starts.truncate(n_levels as usize);
        let n_parents = (n_leaves / WIDTH).max(1);
        let corner = Aabb::of(points).min;
        let mut nodes = vec![Node::EMPTY; starts[starts.len() - 1] + n_parents];
        let (upper, lowest) = nodes.split_at_mut(starts[starts.len() - 1]);
        lowest.par_iter_mut().with_min_len(NODES_AT_ONCE).enumerate().for_each(|(n, node)| {
            for child in 0..WIDTH.min(n_leaves) {
                let leaf = n * WIDTH + child;
                let start = |leaf| leaf_start(leaf, n_leaves, points.len());
                let aabb = Aabb::of(&points[start(leaf)..start(leaf + 1)]);
                node.set(child, &OuterBox::of(&aabb, &corner));
            }
        });
        let mut below: Vec<OuterBox> = lowest.iter().map(Node::all).collect();
        for level in (0..starts.len() - 1).rev() {
            let width = if level == 0 { 1 << root_bits } else { WIDTH };
            let level = &mut upper[starts[level]..starts[level + 1]];
            for (node, children) in level.iter_mut().zip(below.chunks(width)) {
                for (child, aabb) in children.iter().enumerate() {
                    node.set(child, aabb);
                }
            }
            below = level.iter().map(Node::all).collect();
        }
        Self { all: nodes, starts, root_bits, corner }
    }

    #[inline(always)]
    pub(super) fn n_levels(&self) -> usize {
        self.starts.len()
    }

    /// Node `n` of a level.
    #[inline(always)]
    pub(super) fn node(&self, level: usize, n: usize) -> &Node {
        &self.all[self.starts[level] + n]
    }

    /// Places of all nodes of a level.
    pub(super) fn len_of(&self, level: usize) -> usize {
        self.starts.get(level + 1).map_or(self.all.len(), |end| *end) - self.starts[level]
    }

    /// Place in the next level, or of the leaf, of a child of node `n`.
    #[inline(always)]
    pub(super) fn below(&self, level: usize, n: usize, child: usize) -> usize {
        let bits = if level == 0 { self.root_bits } else { BITS };
        (n << bits) + child
    }

    /// Children that nodes of a level have.
    #[inline(always)]
    pub(super) fn width(&self, level: usize) -> usize {
        if level == 0 { 1 << self.root_bits } else { WIDTH }
    }
}
