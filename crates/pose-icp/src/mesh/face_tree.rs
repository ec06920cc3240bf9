//! Faces sorted into boxes that lie along the surface.
//!
//! A ball stands off a surface that bends little: boxes along the axes of coordinates are thick where
//! the surface is oblique, and hundreds of them are as near as the nearest face. Here the boxes of a
//! node are along the mean normal of its faces, and hardly thicker than the surface bends.

#![expect(
    clippy::inline_always,
    reason = "inlined into functions that are compiled for wide registers"
)]

use nalgebra::{Matrix3, Point3, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::Triangle;
use rayon::prelude::*;

use crate::cloud::{Task, dispatch, leaf_start, n_leaves, spatial_order};
use crate::outwards::{above, below};

/// Children of a node, faces of a leaf at most, and values that one register of `f32` holds.
const WIDTH: usize = 8;

/// Levels of a binary tree in one of this.
const BITS: u32 = 3;

/// Siblings that wait on each level of the tallest tree: 2^32 faces.
const MAX_STACK: usize = 80;

/// Nodes that one thread makes at once, at least.
const NODES_AT_ONCE: usize = 64;

/// Bound on the relative rounding of a squared gap, axes of single precision included.
const ROUNDED_DOWN: f32 = 1.0 - 3e-6;

/// The same of a squared distance.
const ROUNDED_UP: f32 = 1.0 + 3e-7;

/// Boxes of the children of a node, in its own frame; one that is not there is turned inside out.
#[derive(Clone, Copy, Debug)]
struct Node {
    origin: [f32; 3],
    /// By rows; the last is the mean normal.
    axes: [[f32; 3]; 3],
    min: [[f32; WIDTH]; 3],
    max: [[f32; WIDTH]; 3],
}

impl Node {
    /// Over faces, so many to a child.
    fn over(
        triangles: &[Triangle],
        children: impl Iterator<Item = std::ops::Range<usize>>,
    ) -> Self {
        let children: Vec<_> = children.collect();
        let all = children[0].start..children[children.len() - 1].end;
        let (mut sum, mut normal) = (Vector3::zeros(), Vector3::zeros());
        for triangle in &triangles[all.clone()] {
            let [a, b, c] = corners(triangle);
            sum += a + b + c;
            normal += (b - a).cross(&(c - a));
        }
        #[expect(clippy::cast_precision_loss, reason = "far below 2^53")]
        let middle = sum / (3 * all.len()) as f64;
        let mut node = Self {
            origin: single(&middle),
            axes: frame(&normal),
            min: [[f32::INFINITY; WIDTH]; 3],
            max: [[f32::NEG_INFINITY; WIDTH]; 3],
        };
        for (child, range) in children.into_iter().enumerate() {
            for triangle in &triangles[range] {
                for corner in corners(triangle) {
                    for (k, at) in node.of(&corner).into_iter().enumerate() {
                        node.min[k][child] = node.min[k][child].min(below(at));
                        node.max[k][child] = node.max[k][child].max(above(at));
                    }
                }
            }
        }
        node
    }

    /// A point in the node's frame.
    #[inline(always)]
    fn of(&self, point: &Vector3<f64>) -> [f64; 3] {
        let d: [f64; 3] = std::array::from_fn(|k| point[k] - f64::from(self.origin[k]));
        self.axes.map(|a| f64::from(a[0]) * d[0] + f64::from(a[1]) * d[1] + f64::from(a[2]) * d[2])
    }

    /// Squared distances of the children from a point, rounded down; infinite for none.
    #[inline(always)]
    fn gaps_squared(&self, point: &Vector3<f64>) -> [f32; WIDTH] {
        let at = self.of(point);
        let mut sums = [0.0_f32; WIDTH];
        for (k, at) in at.into_iter().enumerate() {
            let (low, high) = (below(at), above(at));
            for (lane, sum) in sums.iter_mut().enumerate() {
                let (over, under) = (self.min[k][lane] - high, low - self.max[k][lane]);
                // At most one is positive.
                let gap = if over > under { over } else { under };
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

/// Faces by place in the tree.
#[derive(Clone, Debug)]
pub(super) struct FaceTree {
    triangles: Vec<Triangle>,
    /// Place of each in the mesh.
    order: Vec<u32>,
    nodes: Vec<Node>,
    /// Where each level begins.
    starts: Vec<usize>,
    /// Binary levels that each child of the root lies below it.
    root_bits: u32,
    n_leaves: usize,
}

impl FaceTree {
    /// Of faces by their corners; at least one.
    pub(super) fn new(faces: &[[Point3<f64>; 3]]) -> Self {
        let middles: Vec<Point3<f64>> = faces
            .iter()
            .map(|[a, b, c]| Point3::from((a.coords + b.coords + c.coords) / 3.0))
            .collect();
        let (_, order) = spatial_order(&middles);
        let triangle = |&face: &u32| {
            let [a, b, c] = faces[face as usize].map(|corner| to_parry(&corner));
            Triangle::new(a, b, c)
        };
        let triangles: Vec<Triangle> = order.iter().map(triangle).collect();
        let n_leaves = n_leaves(faces.len());
        // The lowest level has a node to a leaf, whose children are faces.
        let height = n_leaves.trailing_zeros();
        let n_levels = height.div_ceil(BITS) as usize + 1;
        let root_bits =
            if n_levels == 1 { BITS } else { height - BITS * (height.div_ceil(BITS) - 1) };
        let mut tree =
            Self { triangles, order, nodes: Vec::new(), starts: Vec::new(), root_bits, n_leaves };
        for level in 0..n_levels {
            tree.starts.push(tree.nodes.len());
            let n_nodes = n_leaves >> (height - tree.depth(level, n_levels));
            let of_level: Vec<Node> = (0..n_nodes)
                .into_par_iter()
                .with_min_len(NODES_AT_ONCE)
                .map(|n| tree.node(level, n_levels, n))
                .collect();
            tree.nodes.extend(of_level);
        }
        tree
    }

    /// Binary levels above a level.
    fn depth(&self, level: usize, n_levels: usize) -> u32 {
        if level == 0 {
            return 0;
        }
        let from_leaves = (n_levels - 1 - level) * BITS as usize;
        self.n_leaves.trailing_zeros() - u32::try_from(from_leaves).expect("a tree's height")
    }

    fn node(&self, level: usize, n_levels: usize, n: usize) -> Node {
        let start = |leaf| leaf_start(leaf, self.n_leaves, self.triangles.len());
        if level + 1 == n_levels {
            let faces = start(n)..start(n + 1);
            return Node::over(&self.triangles, faces.map(|face| face..face + 1));
        }
        let depth = self.depth(level + 1, n_levels);
        let leaves_each = self.n_leaves >> depth;
        let width = 1 << (depth - self.depth(level, n_levels));
        let children = (0..width).map(|child| {
            let first = (n * width + child) * leaves_each;
            start(first)..start(first + leaves_each)
        });
        Node::over(&self.triangles, children)
    }

    /// Place of each face in the mesh, by place in the tree.
    pub(super) fn order(&self) -> &[u32] {
        &self.order
    }

    pub(super) fn triangle(&self, slot: u32) -> &Triangle {
        &self.triangles[slot as usize]
    }

    /// The face nearest to a point, if one is nearer than the limit: of equals the first in the mesh.
    pub(super) fn nearest(&self, point: &Point3<f64>, limit_mm: f64) -> Option<u32> {
        dispatch(Nearest { tree: self, point: point.coords, limit_mm })
    }

    #[inline(always)]
    fn search(&self, point: &Vector3<f64>, limit_mm: f64) -> Option<u32> {
        let query = Vector::new(point.x, point.y, point.z);
        let lowest = self.starts.len() - 1;
        let mut best = Best::within(limit_mm);
        let mut stack = [Waiting { gap: 0.0, level: 0, node: 0 }; MAX_STACK];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let Waiting { gap, level, node: n } = stack[height];
            if gap > best.reach {
                continue;
            }
            let node = &self.nodes[self.starts[level as usize] + n as usize];
            let gaps = node.gaps_squared(point);
            let mut within = 0_u32;
            for (child, &gap) in gaps.iter().enumerate() {
                within |= u32::from(gap <= best.reach && gap < f32::INFINITY) << child;
            }
            let is_leaf = level as usize == lowest;
            let (mut waiting, first) =
                (height, leaf_start(n as usize, self.n_leaves, self.triangles.len()));
            let (mut nearest, mut nearest_gap) = (None, f32::INFINITY);
            let mut rest = within;
            while rest != 0 {
                let child = rest.trailing_zeros() as usize % WIDTH;
                rest &= rest - 1;
                if gaps[child] < nearest_gap || nearest.is_none() {
                    (nearest, nearest_gap) = (Some(child), gaps[child]);
                }
            }
            let Some(nearest) = nearest else { continue };
            let mut rest = within & !(1 << nearest);
            if is_leaf {
                best.look_at(self, first + nearest, query);
                while rest != 0 {
                    let child = rest.trailing_zeros() as usize % WIDTH;
                    rest &= rest - 1;
                    if gaps[child] <= best.reach {
                        best.look_at(self, first + child, query);
                    }
                }
                continue;
            }
            let bits = if level == 0 { self.root_bits } else { BITS };
            let mut wait = |child: usize| {
                #[expect(clippy::cast_possible_truncation, reason = "below 2^32 nodes")]
                let node = (((n as usize) << bits) + child) as u32;
                stack[waiting] = Waiting { gap: gaps[child], level: level + 1, node };
                waiting += 1;
            };
            while rest != 0 {
                wait(rest.trailing_zeros() as usize % WIDTH);
                rest &= rest - 1;
            }
            wait(nearest);
            height = waiting;
        }
        best.slot
    }
}

struct Nearest<'a> {
    tree: &'a FaceTree,
    point: Vector3<f64>,
    limit_mm: f64,
}

impl Task for Nearest<'_> {
    type Output = Option<u32>;

    #[inline(always)]
    fn run(self) -> Option<u32> {
        self.tree.search(&self.point, self.limit_mm)
    }
}

/// A node that may be within reach.
#[derive(Clone, Copy)]
struct Waiting {
    gap: f32,
    level: u32,
    node: u32,
}

/// The nearest face so far.
struct Best {
    slot: Option<u32>,
    squared: f64,
    /// The same in single precision, rounded up.
    reach: f32,
}

impl Best {
    #[inline(always)]
    fn within(limit_mm: f64) -> Self {
        let squared = limit_mm * limit_mm;
        Self { slot: None, squared, reach: Self::reach(squared) }
    }

    #[inline(always)]
    fn reach(squared: f64) -> f32 {
        #[expect(clippy::cast_possible_truncation, reason = "rounded up")]
        let single = squared as f32;
        single * ROUNDED_UP + f32::MIN_POSITIVE
    }

    #[inline(always)]
    fn look_at(&mut self, tree: &FaceTree, slot: usize, query: Vector) {
        let projected = tree.triangles[slot].project_local_point(query, false);
        let squared = (projected.point - query).length_squared();
        let is_first = squared.to_bits() == self.squared.to_bits()
            && self.slot.is_some_and(|known| tree.order[slot] < tree.order[known as usize]);
        if squared < self.squared || is_first {
            #[expect(clippy::cast_possible_truncation, reason = "below 2^32 faces")]
            let slot = slot as u32;
            *self = Self { slot: Some(slot), squared, reach: Self::reach(squared) };
        }
    }
}

fn corners(triangle: &Triangle) -> [Vector3<f64>; 3] {
    [triangle.a, triangle.b, triangle.c].map(|v| Vector3::new(v.x, v.y, v.z))
}

/// Axes by rows, the last along a normal; those of coordinates where there is none.
fn frame(normal: &Vector3<f64>) -> [[f32; 3]; 3] {
    let axes = normal.try_normalize(f64::MIN_POSITIVE).map_or_else(Matrix3::identity, |normal| {
        let across = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
        Matrix3::from_columns(&[across, normal.cross(&across), normal])
    });
    std::array::from_fn(|row| single(&axes.column(row).into_owned()))
}

#[expect(clippy::cast_possible_truncation, reason = "any frame near to it will do")]
fn single(v: &Vector3<f64>) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

pub(super) fn to_parry(point: &Point3<f64>) -> Vector {
    Vector::new(point.x, point.y, point.z)
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;
    use parry3d_f64::query::PointQuery;
    use proptest::prelude::*;

    use super::{FaceTree, to_parry};

    fn check(faces: &[[Point3<f64>; 3]], queries: &[Point3<f64>]) {
        let tree = FaceTree::new(faces);
        let distance = |slot: u32, query: &Point3<f64>| {
            let query = to_parry(query);
            (tree.triangle(slot).project_local_point(query, false).point - query).length()
        };
        for query in queries {
            let slots = 0..u32::try_from(faces.len()).unwrap();
            let least = slots.map(|slot| distance(slot, query)).fold(f64::INFINITY, f64::min);
            let found = tree.nearest(query, f64::MAX).expect("there are faces");
            assert_eq!(distance(found, query).to_bits(), least.to_bits(), "query {query}");
            // Nothing is nearer than the nearest, and it is found within a little more.
            assert_eq!(tree.nearest(query, least * (1.0 - 1e-12)), None, "query {query}");
            if least > 0.0 {
                assert_eq!(tree.nearest(query, least * (1.0 + 1e-12)), Some(found));
            }
        }
    }

    fn point(size: f64) -> impl Strategy<Value = Point3<f64>> {
        prop::array::uniform3(-size..size).prop_map(Point3::from)
    }

    /// On a lattice, so that corners coincide and distances tie.
    fn lattice() -> impl Strategy<Value = Point3<f64>> {
        prop::array::uniform3(-3_i8..3).prop_map(|v| Point3::from(v.map(f64::from)))
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            cases: 150,
            rng_seed: proptest::test_runner::RngSeed::Fixed(4),
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        #[test]
        fn finds_the_nearest_of_any_faces(
            faces in prop::collection::vec(prop::array::uniform3(point(10.0)), 1..200),
            queries in prop::collection::vec(point(25.0), 1..30),
        ) {
            check(&faces, &queries);
        }

        #[test]
        fn ties_do_no_harm(
            faces in prop::collection::vec(prop::array::uniform3(lattice()), 1..120),
            queries in prop::collection::vec(lattice(), 1..30),
        ) {
            let is_face = |[a, b, c]: &[Point3<f64>; 3]| (b - a).cross(&(c - a)).norm() > 0.0;
            let faces: Vec<_> = faces.into_iter().filter(is_face).collect();
            if !faces.is_empty() {
                check(&faces, &queries);
            }
        }
    }

    #[test]
    fn finds_the_nearest_on_a_bowl_far_from_the_origin_and_far_off() {
        let at = |i: u32, j: u32| {
            let (x, y) = (f64::from(i) * 0.3 - 9.0, f64::from(j) * 0.3 - 9.0);
            Point3::new(1e5 + x, -2e5 + y, 3e4 + (x * x + y * y) / 40.0)
        };
        let cell = |i, j| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        let faces: Vec<_> = (0..60).flat_map(|i| (0..60).flat_map(move |j| cell(i, j))).collect();
        let above = |k: u32| {
            let (i, j) = (k * 7 % 60, k * 11 % 60);
            let height = [3.0, 1e-9, 19.9, 20.1, 4e4][k as usize % 5];
            at(i, j) + nalgebra::Vector3::new(0.01 * f64::from(k % 13), 0.02, height)
        };
        check(&faces, &(0..300).map(above).collect::<Vec<_>>());
    }
}
