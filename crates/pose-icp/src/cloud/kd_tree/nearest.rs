//! The nearest points of a single query.

use nalgebra::Point3;

use super::boxes::{Aabb, OuterBox};
use super::tree::KdTree;

impl KdTree {
    /// Squared distances and slots of the nearest points of a query, the nearest first.
    ///
    /// At most `count`; fewer where the tree holds fewer. `nearest` is overwritten.
    pub(crate) fn nearest(&self, query: &Point3<f64>, count: usize, nearest: &mut Vec<(f64, u32)>) {
        nearest.clear();
        let here = OuterBox::of(&Aabb::of(std::slice::from_ref(query)), &self.nodes.corner);
        self.visit(0, 0, query, &here, count, nearest);
    }

    fn visit(
        &self,
        level: usize,
        n: usize,
        query: &Point3<f64>,
        here: &OuterBox,
        count: usize,
        nearest: &mut Vec<(f64, u32)>,
    ) {
        let gaps = self.nodes.node(level, n).gaps_squared(here);
        let width = self.nodes.width(level);
        let mut order: [usize; 8] = std::array::from_fn(|child| child);
        let order = &mut order[..width];
        order.sort_by(|&a, &b| gaps[a].total_cmp(&gaps[b]));
        for &child in &*order {
            let worst = nearest.last().filter(|_| nearest.len() == count);
            if worst.is_some_and(|worst| f64::from(gaps[child]) >= worst.0) {
                return;
            }
            let below = self.nodes.below(level, n, child);
            if level + 1 < self.nodes.n_levels() {
                self.visit(level + 1, below, query, here, count, nearest);
            } else {
                self.insert_leaf(below, query, count, nearest);
            }
        }
    }

    fn insert_leaf(
        &self,
        leaf: usize,
        query: &Point3<f64>,
        count: usize,
        nearest: &mut Vec<(f64, u32)>,
    ) {
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
