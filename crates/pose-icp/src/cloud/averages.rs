//! Noise of a target, averaged over the few points of a leaf.

use nalgebra::{Point3, Vector3};

use super::kd_tree::{KdTree, leaf_of};

/// Leaves that the noise of a target is estimated from, at most.
const SAMPLES: usize = 512;

/// Points of a leaf are averaged where their mean normal is at least this long: within some 10°.
const MIN_MEAN_NORMAL: f64 = 0.985;

/// Mean square within a leaf, over that of the usual one, above which it has a step or an edge.
const MAX_OVER_USUAL: f64 = 9.0;

/// Noise sets near points of a leaf as far apart in height as far ones, an error of the mean normal by
/// the cube of their distance.
const MIN_NEAR_SHARE: f64 = 0.5;

/// Share of the squared residuals that noise of the target must at least make up to be averaged.
const MIN_SHARE: f64 = 0.1;

/// How far the surface lies above each point, by the other points of its leaf.
///
/// Two points of a surface with normals n₁ and n₂ lie `½(n₁ + n₂)·(q₁ − q₂)` apart in height, to the
/// third order: exactly nothing on a circle. The mean of that over a leaf takes most of the noise of
/// its points away, where the nearest one alone gives a source point all of its own.
#[derive(Clone, Debug)]
pub(crate) struct Averages {
    /// Along the normal, by slot.
    pub(crate) lift_mm: Vec<f32>,
    /// Mean square of what the average of a leaf is still off by.
    pub(crate) variance_mm2: f64,
    n_leaves: usize,
}

impl Averages {
    /// How many rows use the average that a row uses, in the mean over rows to these slots.
    pub(crate) fn rows_to_one(&self, slots: &[u32]) -> f64 {
        let mut counts = vec![0_u32; self.n_leaves];
        for &slot in slots {
            counts[leaf_of(slot as usize, self.n_leaves, self.lift_mm.len())] += 1;
        }
        let sum: f64 = counts.iter().map(|&c| f64::from(c)).sum();
        let squares: f64 = counts.iter().map(|&c| f64::from(c).powi(2)).sum();
        if sum > 0.0 { squares / sum } else { 1.0 }
    }
}

/// The averages, where the noise of the target's points shows in squared residuals of this mean;
/// where it is larger than those, what tells the points of a leaf apart is no noise.
pub(crate) fn averages(
    tree: &KdTree,
    normals: &[Vector3<f64>],
    residual_mm2: f64,
) -> Option<Averages> {
    let step = tree.n_leaves().div_ceil(SAMPLES);
    let sampled = (0..tree.n_leaves()).step_by(step);
    let leaves: Vec<Leaf> = sampled.filter_map(|leaf| Leaf::of(tree, normals, leaf)).collect();
    let usual_mm2 = median(leaves.iter().map(Leaf::variance_mm2).collect())?;
    let (near, far): (Vec<f64>, Vec<f64>) =
        leaves.iter().filter_map(Leaf::near_and_far_mm2).unzip();
    let is_noise = median(near)? >= MIN_NEAR_SHARE * median(far)?;
    if !(is_noise && usual_mm2 >= MIN_SHARE * residual_mm2 && usual_mm2 <= residual_mm2) {
        return None;
    }
    let mut lift_mm = vec![0.0; normals.len()];
    let (mut sum_mm2, mut n_averaged) = (0.0, 0.0);
    for leaf in 0..tree.n_leaves() {
        let Some(of) = Leaf::of(tree, normals, leaf) else { continue };
        let variance_mm2 = of.variance_mm2();
        if variance_mm2 > MAX_OVER_USUAL * usual_mm2 {
            continue;
        }
        for slot in tree.leaf(leaf) {
            #[expect(clippy::cast_possible_truncation, reason = "a small length")]
            let lift = of.lift_mm(&tree.points()[slot], &normals[slot]) as f32;
            lift_mm[slot] = lift;
        }
        sum_mm2 += variance_mm2 / of.count;
        n_averaged += 1.0;
    }
    let n_leaves = tree.n_leaves();
    (n_averaged > 0.0).then(|| Averages { lift_mm, variance_mm2: sum_mm2 / n_averaged, n_leaves })
}

/// What the mean over a leaf needs, from its first point.
struct Leaf<'a> {
    points: &'a [Point3<f64>],
    normals: &'a [Vector3<f64>],
    origin: Point3<f64>,
    count: f64,
    mean_point: Vector3<f64>,
    mean_normal: Vector3<f64>,
    /// Mean of normal times point.
    mean_product_mm: f64,
}

impl<'a> Leaf<'a> {
    /// `None` where the points are too few, or face different ways.
    fn of(tree: &'a KdTree, normals: &'a [Vector3<f64>], leaf: usize) -> Option<Self> {
        let slots = tree.leaf(leaf);
        let (points, normals) = (&tree.points()[slots.clone()], &normals[slots]);
        let origin = *points.first()?;
        if points.len() < 3 {
            return None;
        }
        let (mut point, mut normal, mut product) = (Vector3::zeros(), Vector3::zeros(), 0.0);
        for (p, n) in points.iter().zip(normals) {
            let offset = p - origin;
            point += offset;
            normal += n;
            product += n.dot(&offset);
        }
        #[expect(clippy::cast_precision_loss, reason = "a few points")]
        let count = points.len() as f64;
        let mean_normal = normal / count;
        (mean_normal.norm() >= MIN_MEAN_NORMAL).then_some(Self {
            points,
            normals,
            origin,
            count,
            mean_point: point / count,
            mean_normal,
            mean_product_mm: product / count,
        })
    }

    /// Mean of `½(nᵢ + n)·(qᵢ − q)` over the leaf.
    fn lift_mm(&self, point: &Point3<f64>, normal: &Vector3<f64>) -> f64 {
        let offset = point - self.origin;
        0.5 * (self.mean_product_mm - self.mean_normal.dot(&offset)
            + normal.dot(&(self.mean_point - offset)))
    }

    /// Mean squared differences in height of the nearer and of the further half of all pairs.
    fn near_and_far_mm2(&self) -> Option<(f64, f64)> {
        let mut pairs = Vec::new();
        for (i, (p, n)) in self.points.iter().zip(self.normals).enumerate() {
            for (q, m) in self.points[..i].iter().zip(self.normals) {
                let offset = p - q;
                pairs.push((offset.norm_squared(), (0.5 * (n + m).dot(&offset)).powi(2)));
            }
        }
        pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let (near, far) = pairs.split_at(pairs.len() / 2);
        Some((mean(near)?, mean(far)?))
    }

    /// Of a point about the surface.
    fn variance_mm2(&self) -> f64 {
        let lifts = self.points.iter().zip(self.normals).map(|(p, n)| self.lift_mm(p, n).powi(2));
        lifts.sum::<f64>() / (self.count - 1.0)
    }
}

#[expect(clippy::cast_precision_loss, reason = "a few pairs")]
fn mean(pairs: &[(f64, f64)]) -> Option<f64> {
    (!pairs.is_empty()).then(|| pairs.iter().map(|p| p.1).sum::<f64>() / pairs.len() as f64)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
