use std::ops::ControlFlow;

use nalgebra::{Point3, Vector3};

use super::patch::{Leaf, bounds, meets_box};
use crate::Line;

/// Leaves below which a box is not halved.
const FEW: usize = 2;

/// Boxes within boxes over the leaves of a surface.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tree {
    leaves: Vec<Leaf>,
    nodes: Vec<Node>,
}

#[derive(Clone, Debug, PartialEq)]
struct Node {
    low_mm: Vector3<f64>,
    high_mm: Vector3<f64>,
    /// Leaves in this box.
    from: usize,
    to: usize,
    /// The second of the halves, the first of which comes next; `None` where there are none.
    second: Option<usize>,
}

impl Tree {
    pub(super) fn new(mut leaves: Vec<Leaf>) -> Self {
        let mut nodes = Vec::new();
        let count = leaves.len();
        build(&mut leaves, 0, count, &mut nodes);
        Self { leaves, nodes }
    }

    /// Half the diagonal of the box about everything.
    pub(super) fn reach_mm(&self) -> f64 {
        self.nodes.first().map_or(0.0, |node| 0.5 * (node.high_mm - node.low_mm).norm())
    }

    /// Visits the leaves within a distance of a point, near ones first; each visit says within which
    /// distance leaves count from then on.
    pub(super) fn each_near(&self, query_mm: &Point3<f64>, visit: &mut impl FnMut(&Leaf) -> f64) {
        let mut within_mm = f64::INFINITY;
        self.near(0, query_mm, &mut within_mm, visit);
    }

    fn near(
        &self,
        index: usize,
        query_mm: &Point3<f64>,
        within_mm: &mut f64,
        visit: &mut impl FnMut(&Leaf) -> f64,
    ) {
        let node = &self.nodes[index];
        if node.distance_mm(query_mm) > *within_mm {
            return;
        }
        let Some(second) = node.second else {
            for leaf in &self.leaves[node.from..node.to] {
                if leaf.distance_mm(query_mm) <= *within_mm {
                    *within_mm = visit(leaf);
                }
            }
            return;
        };
        let first = index + 1;
        let [a, b] = [first, second].map(|child| self.nodes[child].distance_mm(query_mm));
        let order = if b < a { [second, first] } else { [first, second] };
        for child in order {
            self.near(child, query_mm, within_mm, visit);
        }
    }

    /// Visits the leaves whose box a line meets.
    pub(super) fn each_met(
        &self,
        line: &Line,
        visit: &mut impl FnMut(&Leaf) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.met(0, line, visit)
    }

    fn met(
        &self,
        index: usize,
        line: &Line,
        visit: &mut impl FnMut(&Leaf) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let node = &self.nodes[index];
        let middle = (node.low_mm + node.high_mm) * 0.5;
        let half = (node.high_mm - node.low_mm) * 0.5;
        let from = line.point_mm.coords - middle;
        let slack = Vector3::repeat(1e-12 * (1.0 + from.amax()));
        if !meets_box(&from, &line.direction, &(half + slack)) {
            return ControlFlow::Continue(());
        }
        match node.second {
            Some(second) => {
                self.met(index + 1, line, visit)?;
                self.met(second, line, visit)
            }
            None => self.leaves[node.from..node.to]
                .iter()
                .filter(|l| l.is_met(line))
                .try_for_each(visit),
        }
    }
}

impl Node {
    fn distance_mm(&self, query_mm: &Point3<f64>) -> f64 {
        let q = &query_mm.coords;
        let beside = (self.low_mm - q).sup(&(q - self.high_mm));
        beside.map(|v| v.max(0.0)).norm()
    }
}

fn build(leaves: &mut [Leaf], from: usize, to: usize, nodes: &mut Vec<Node>) {
    let here = &mut leaves[from..to];
    let corners = here.iter().flat_map(|leaf| [&leaf.low_mm, &leaf.high_mm]);
    let (low_mm, high_mm) = bounds(corners);
    let index = nodes.len();
    nodes.push(Node { low_mm, high_mm, from, to, second: None });
    if to - from <= FEW {
        return;
    }
    let axis = (high_mm - low_mm).imax();
    let middle = |leaf: &Leaf| leaf.low_mm[axis] + leaf.high_mm[axis];
    let half = (to - from) / 2;
    here.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
    build(leaves, from, from + half, nodes);
    nodes[index].second = Some(nodes.len());
    build(leaves, from + half, to, nodes);
}
