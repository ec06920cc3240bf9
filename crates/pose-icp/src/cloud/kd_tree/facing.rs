//! Which way the surface faces in the boxes of a tree, and what must therefore lie beside it.

use nalgebra::Vector3;

use super::boxes::Aabb;
use super::tree::KdTree;
use super::wide::WIDTH;

/// Nodes looked at before a group of queries is searched for instead.
const MAX_NODES: usize = 64;

/// Share of a distance that covers the rounding of axes and of a few operations.
const ROUNDING: f64 = 1e-6;

/// How a point must lie to count as beside the target point that is nearest to it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BesideRule {
    /// A point is beside if it is further sideways than the reach and this share of its height.
    pub(crate) per_height: f64,
}

/// Normals of the points in a box, as lines.
#[derive(Clone, Copy, Debug)]
struct Cone {
    axis: [f32; 3],
    /// Cosine of the largest angle between the axis and a normal, at most.
    cos: f32,
    /// Largest reach of a point.
    reach_mm: f32,
}

impl Cone {
    /// Of nothing that could be beside.
    const ANY: Self = Self { axis: [0.0, 0.0, 1.0], cos: 0.0, reach_mm: f32::INFINITY };
}

/// Cones of all boxes but the leaves, as the tree's nodes are laid out.
#[derive(Clone, Debug)]
pub(crate) struct Facing {
    levels: Vec<Vec<[Cone; WIDTH]>>,
}

impl Facing {
    /// Of points with unit normals and reaches by slot.
    pub(crate) fn of(tree: &KdTree, normals: &[Vector3<f64>], reach_mm: &[f32]) -> Self {
        let lowest = tree.nodes.n_levels() - 1;
        let mut below: Vec<Cone> = (0..tree.nodes.len_of(lowest))
            .map(|n| {
                let width = tree.nodes.width(lowest);
                let from = tree.leaf(n * width).start;
                let slots = from..tree.leaf((n + 1) * width - 1).end;
                cone_of_points(&normals[slots.clone()], &reach_mm[slots])
            })
            .collect();
        let mut levels = Vec::new();
        for level in (0..lowest).rev() {
            let width = tree.nodes.width(level);
            let cones: Vec<[Cone; WIDTH]> = below
                .chunks(width)
                .map(|of_children| {
                    std::array::from_fn(|c| of_children.get(c).copied().unwrap_or(Cone::ANY))
                })
                .collect();
            below = below.chunks(width).map(cone_of_cones).collect();
            levels.push(cones);
        }
        levels.reverse();
        Self { levels }
    }

    /// How far every point of a box may move and still be beside whatever is nearest to it, by the
    /// rule; `None` where that is not sure of all of them.
    pub(crate) fn beside_for_mm(
        &self,
        tree: &KdTree,
        aabb: &Aabb,
        rule: BesideRule,
    ) -> Option<f64> {
        let corner = Vector3::from(tree.nodes.corner);
        let (min, max) = (Vector3::from(aabb.min), Vector3::from(aabb.max));
        let center = 0.5 * (min + max) - corner;
        let radius_mm = 0.5 * (max - min).norm();
        let mut margin_mm = f64::INFINITY;
        let mut waiting = [(0_u32, 0_u32); MAX_NODES];
        let (mut height, mut seen) = (1, 1);
        while height > 0 {
            height -= 1;
            let (level, n) = (waiting[height].0 as usize, waiting[height].1 as usize);
            let cones = self.levels.get(level)?.get(n)?;
            let node = tree.nodes.node(level, n);
            for (child, cone) in cones.iter().enumerate().take(tree.nodes.width(level)) {
                let aabb = node.child(child);
                let low = Vector3::from(aabb.min.map(f64::from));
                let high = Vector3::from(aabb.max.map(f64::from));
                let offset = center - 0.5 * (low + high);
                let spread_mm = radius_mm + 0.5 * (high - low).norm();
                let margin = cone.margin_mm(&offset, spread_mm, rule);
                if margin > 0.0 {
                    margin_mm = margin_mm.min(margin);
                } else if level + 1 < self.levels.len() && seen < MAX_NODES {
                    #[expect(clippy::cast_possible_truncation, reason = "below 2^32 nodes")]
                    let next = (level as u32 + 1, tree.nodes.below(level, n, child) as u32);
                    waiting[height] = next;
                    height += 1;
                    seen += 1;
                } else {
                    return None;
                }
            }
        }
        // A move changes what is left sideways by itself, and the height as well.
        margin_mm.is_finite().then(|| margin_mm / (1.0 + rule.per_height))
    }
}

impl Cone {
    /// By how much a point is beside that lies `offset` from the middle of the box, or up to
    /// `spread_mm` further; negative where it may not be.
    fn margin_mm(&self, offset: &Vector3<f64>, spread_mm: f64, rule: BesideRule) -> f64 {
        let axis = Vector3::from(self.axis.map(f64::from));
        let along = offset.dot(&axis).abs();
        let squared = offset.norm_squared();
        let across = (squared - along * along).max(0.0).sqrt();
        let cos = f64::from(self.cos);
        let sin = (1.0 - cos * cos).sqrt();
        let sideways = across * cos - along * sin - spread_mm;
        let height = along * cos + across * sin + spread_mm;
        let slack = ROUNDING * (squared.sqrt() + spread_mm);
        sideways - f64::from(self.reach_mm) - rule.per_height * height - slack
    }
}

fn cone_of_points(normals: &[Vector3<f64>], reach_mm: &[f32]) -> Cone {
    let Some(first) = normals.first() else { return Cone::ANY };
    let sum = normals
        .iter()
        .fold(Vector3::zeros(), |sum, n| if n.dot(first) < 0.0 { sum - n } else { sum + n });
    let Some(axis) = sum.try_normalize(f64::MIN_POSITIVE) else { return Cone::ANY };
    let least = normals.iter().map(|n| n.dot(&axis).abs() / n.norm()).fold(1.0, f64::min);
    let reach_mm = reach_mm.iter().copied().fold(0.0, f32::max);
    Cone { axis: single(&axis), cos: lowered(least), reach_mm }
}

fn cone_of_cones(children: &[Cone]) -> Cone {
    let of = |cone: &Cone| Vector3::from(cone.axis.map(f64::from));
    let first = of(&children[0]);
    let sum = children.iter().map(of).fold(Vector3::zeros(), |sum, axis| {
        if axis.dot(&first) < 0.0 { sum - axis } else { sum + axis }
    });
    let Some(axis) = sum.try_normalize(f64::MIN_POSITIVE) else { return Cone::ANY };
    let widest = children.iter().map(|child| {
        let apart = of(child).dot(&axis).abs().min(1.0).acos();
        apart + f64::from(child.cos).acos()
    });
    let widest = widest.fold(0.0, f64::max);
    let reach_mm = children.iter().map(|c| c.reach_mm).fold(0.0, f32::max);
    if widest >= std::f64::consts::FRAC_PI_2 {
        return Cone { reach_mm, ..Cone::ANY };
    }
    Cone { axis: single(&axis), cos: lowered(widest.cos()), reach_mm }
}

#[expect(clippy::cast_possible_truncation, reason = "covered by what is taken off the cosine")]
fn single(axis: &Vector3<f64>) -> [f32; 3] {
    [axis.x as f32, axis.y as f32, axis.z as f32]
}

#[expect(clippy::cast_possible_truncation, reason = "rounded to the safe side")]
fn lowered(cos: f64) -> f32 {
    (cos - ROUNDING).max(0.0) as f32
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::super::{Aabb, KdTree};
    use super::{BesideRule, Facing};

    const RULE: BesideRule = BesideRule { per_height: 0.2 };

    /// Whether a point is beside the target point that is nearest to it, by every distance there is.
    fn is_beside(
        tree: &KdTree,
        normals: &[Vector3<f64>],
        reach_mm: &[f32],
        query: &Point3<f64>,
    ) -> bool {
        let squared = |slot: &usize| (tree.points()[*slot] - query).norm_squared();
        let slots = 0..tree.points().len();
        let nearest = slots.min_by(|a, b| squared(a).total_cmp(&squared(b))).unwrap();
        let offset = query - tree.points()[nearest];
        let height = normals[nearest].dot(&offset);
        let sideways = (offset.norm_squared() - height * height).max(0.0).sqrt();
        sideways > f64::from(reach_mm[nearest]) + RULE.per_height * height.abs()
    }

    #[test]
    fn what_is_sure_to_be_beside_is_and_stays_so_while_it_moves_as_far_as_said() {
        let surface = |i: u32| {
            let (x, y) = (f64::from(i % 60) * 0.5 - 15.0, f64::from(i / 60) * 0.5 - 15.0);
            let normal = Vector3::new(-x / 60.0, -y / 30.0, 1.0).normalize();
            (Point3::new(x, y, x * x / 120.0 + y * y / 60.0), normal)
        };
        let (points, by_input): (Vec<_>, Vec<_>) = (0..3600).map(surface).unzip();
        let tree = KdTree::new(&points);
        // Signs of normals say nothing.
        let sign = |i: usize| if i.is_multiple_of(3) { -1.0 } else { 1.0 };
        let signed: Vec<_> = by_input.iter().enumerate().map(|(i, n)| n * sign(i)).collect();
        let normals = tree.in_slots(&signed);
        let reach_mm = tree.leaf_reaches();
        let facing = Facing::of(&tree, &normals, &reach_mm);
        let (mut sure, mut unsure) = (0, 0);
        for k in 0..400_u32 {
            let (i, j) = (f64::from(k % 20), f64::from(k / 20));
            let low = Point3::new(4.0 * i - 40.0, 4.0 * j - 40.0, f64::from(k % 7) * 3.0 - 6.0);
            let corners: Vec<Point3<f64>> = (0..8_u32)
                .map(|c| {
                    let side = |bit: u32| f64::from(c >> bit & 1);
                    low + Vector3::new(side(0), 1.5 * side(1), 0.5 * side(2))
                })
                .collect();
            let aabb = Aabb::of(&corners);
            let Some(margin_mm) = facing.beside_for_mm(&tree, &aabb, RULE) else {
                unsure += 1;
                continue;
            };
            sure += 1;
            let angle = 0.7 * f64::from(k);
            let way = Vector3::new(angle.cos(), angle.sin(), 0.3 * (2.0 * angle).sin()).normalize();
            for corner in &corners {
                for share in [0.0, 0.5, 0.999] {
                    let moved = corner + way * (share * margin_mm);
                    assert!(
                        is_beside(&tree, &normals, &reach_mm, &moved),
                        "{moved} of {margin_mm}"
                    );
                }
            }
        }
        // The part covers 14 % of the field, and a rim of it is not sure.
        assert!(sure > 200 && unsure > 50, "{sure} sure, {unsure} not");
    }
}
