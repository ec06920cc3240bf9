//! The nearest points of a single query.

use nalgebra::Point3;

use super::{Aabb, KdTree};

impl KdTree {
    /// Squared distances and slots of the nearest points of a query, the nearest first.
    ///
    /// At most `count`; fewer where the tree holds fewer. `nearest` is overwritten.
    pub(crate) fn nearest(&self, query: &Point3<f64>, count: usize, nearest: &mut Vec<(f64, u32)>) {
        nearest.clear();
        let here = Aabb::of(std::slice::from_ref(query));
        self.visit(1, 0.0, &here, count, nearest);
    }

    fn visit(
        &self,
        node: usize,
        gap: f64,
        here: &Aabb,
        count: usize,
        nearest: &mut Vec<(f64, u32)>,
    ) {
        if nearest.len() == count && nearest.last().is_none_or(|worst| gap >= worst.0) {
            return;
        }
        if node >= self.n_leaves {
            self.insert_leaf(node - self.n_leaves, here, count, nearest);
            return;
        }
        let mut children =
            [2 * node, 2 * node + 1].map(|child| (self.boxes[child].gap_squared(here), child));
        if children[1].0 < children[0].0 {
            children.swap(0, 1);
        }
        for (gap, child) in children {
            self.visit(child, gap, here, count, nearest);
        }
    }

    fn insert_leaf(&self, leaf: usize, here: &Aabb, count: usize, nearest: &mut Vec<(f64, u32)>) {
        let query = Point3::from(here.min);
        for slot in self.leaf(leaf) {
            let distance = (self.points[slot] - query).norm_squared();
            if nearest.len() < count || nearest.last().is_some_and(|worst| distance < worst.0) {
                let at = nearest.partition_point(|known| known.0 <= distance);
                #[expect(clippy::cast_possible_truncation, reason = "slots are below 2^32")]
                nearest.insert(at, (distance, slot as u32));
                nearest.truncate(count);
            }
        }
    }
}
