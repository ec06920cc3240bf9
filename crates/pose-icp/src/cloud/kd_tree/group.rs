//! Nearest points of many neighbouring queries.

#![expect(
    clippy::inline_always,
    reason = "inlined into functions that are compiled for wide registers"
)]

use nalgebra::Point3;

use super::{Aabb, KdTree, LANES};

/// Slot that stands for «nothing within reach».
pub(crate) const NONE: u32 = u32::MAX;

/// Height of the tallest tree: 2^32 points.
const MAX_STACK: usize = 64;

/// Covers the rounding of a few operations, in squared distances too.
const ROUNDED_UP: f64 = 1.0 + 1e-14;

/// The same for single precision, downwards.
const ROUNDED_DOWN_F32: f64 = 1.0 - 2e-7;

/// Nearest point of one query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Found {
    /// Its slot, or [`NONE`].
    pub(crate) slot: u32,
    /// How much nearer it is than any other point, at least; the query may move by half of it.
    pub(crate) lead_mm: f32,
}

impl Found {
    pub(crate) const NOTHING: Self = Self { slot: NONE, lead_mm: 0.0 };
}

struct Lanes {
    x: [f64; LANES],
    y: [f64; LANES],
    z: [f64; LANES],
    /// Squared distance of the nearest point so far.
    best: [f64; LANES],
    /// The same of the second nearest.
    second: [f64; LANES],
    slot: [u64; LANES],
}

impl KdTree {
    /// Finds the nearest point of each query within `limit_mm`.
    ///
    /// Queries should be neighbours of one another. What `found` holds already serves as a hint.
    /// Points that are further than the nearest by less than `margin_mm` are looked at too, so
    /// that leads up to that are seen.
    #[inline(always)]
    pub(crate) fn search(
        &self,
        queries: &[Point3<f64>],
        limit_mm: f64,
        margin_mm: f64,
        found: &mut [Found],
    ) {
        let mut near = None;
        for (queries, found) in queries.chunks(LANES).zip(found.chunks_mut(LANES)) {
            let aabb = Aabb::of(queries);
            let near_slot = near.unwrap_or_else(|| self.leaf(self.descend(&aabb.center())).start);
            let reach = self.reach(queries, found, near_slot, limit_mm);
            let mut lanes = Lanes::new(queries, limit_mm);
            let pruned = self.walk(&aabb, &mut lanes, reach, margin_mm);
            for (lane, found) in found.iter_mut().enumerate() {
                *found = lanes.found(lane, pruned);
            }
            near = found.iter().rev().find(|f| f.slot != NONE).map(|f| f.slot as usize);
        }
    }

    /// Distance within which every query of a group has a point, if it has one within the limit.
    #[inline(always)]
    fn reach(&self, queries: &[Point3<f64>], found: &[Found], near: usize, limit_mm: f64) -> f64 {
        let mut reach_squared = 0.0_f64;
        for (query, found) in queries.iter().zip(found) {
            let hint = if found.slot == NONE { near } else { found.slot as usize };
            reach_squared = reach_squared.max((self.points[hint] - query).norm_squared());
        }
        reach_squared.sqrt().min(limit_mm)
    }

    /// Leaf into whose boxes a point falls, or nearly falls.
    #[inline(always)]
    fn descend(&self, point: &Point3<f64>) -> usize {
        let here = Aabb::of(std::slice::from_ref(point));
        let mut node = 1;
        while node < self.n_leaves {
            let [low, high] = [2 * node, 2 * node + 1];
            let nearer_high =
                self.boxes[high].gap_squared(&here) < self.boxes[low].gap_squared(&here);
            node = if nearer_high { high } else { low };
        }
        node - self.n_leaves
    }

    /// Looks at every leaf within reach; returns the distance beyond which nothing was looked at.
    #[inline(always)]
    fn walk(&self, aabb: &Aabb, lanes: &mut Lanes, reach: f64, margin_mm: f64) -> f64 {
        let mut radius = (reach + margin_mm) * ROUNDED_UP;
        let mut radius_squared = radius * radius;
        let mut stack = [(0.0, 0_u32); MAX_STACK];
        let mut height = 0;
        let mut node = 1_usize;
        loop {
            if node >= self.n_leaves {
                lanes.scan(&self.points, self.leaf(node - self.n_leaves));
                let worst = lanes.worst().sqrt();
                let worst = (worst + margin_mm) * ROUNDED_UP;
                if worst < radius {
                    radius = worst;
                    radius_squared = radius * radius;
                }
            } else {
                let (low, high) = (2 * node, 2 * node + 1);
                let (gap_low, gap_high) =
                    (self.boxes[low].gap_squared(aabb), self.boxes[high].gap_squared(aabb));
                let is_high_nearer = gap_high < gap_low;
                let (nearer, gap) = if is_high_nearer { (high, gap_high) } else { (low, gap_low) };
                let (further, other_gap) =
                    if is_high_nearer { (low, gap_low) } else { (high, gap_high) };
                if other_gap <= radius_squared {
                    #[expect(clippy::cast_possible_truncation, reason = "below 2^32 nodes")]
                    let further = further as u32;
                    stack[height] = (other_gap, further);
                    height += 1;
                }
                if gap <= radius_squared {
                    node = nearer;
                    continue;
                }
            }
            loop {
                if height == 0 {
                    return radius;
                }
                height -= 1;
                let (gap, next) = stack[height];
                if gap <= radius_squared {
                    node = next as usize;
                    break;
                }
            }
        }
    }
}

impl Lanes {
    /// Lanes beyond the last query repeat it.
    #[inline(always)]
    fn new(queries: &[Point3<f64>], limit_mm: f64) -> Self {
        let last = queries.len() - 1;
        let (mut x, mut y, mut z) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let query = &queries[lane.min(last)];
            (x[lane], y[lane], z[lane]) = (query.x, query.y, query.z);
        }
        let limit = limit_mm * limit_mm;
        Self {
            x,
            y,
            z,
            best: [limit; LANES],
            second: [f64::INFINITY; LANES],
            slot: [u64::from(NONE); LANES],
        }
    }

    /// Squared distance of the lane that has come least near.
    #[inline(always)]
    fn worst(&self) -> f64 {
        let mut worst = 0.0;
        for &best in &self.best {
            worst = if best > worst { best } else { worst };
        }
        worst
    }

    #[inline(always)]
    fn scan(&mut self, points: &[Point3<f64>], range: std::ops::Range<usize>) {
        let mut next = range.start as u64;
        for point in &points[range] {
            let slot = next;
            next = next.wrapping_add(1);
            let (px, py, pz) = (point.x, point.y, point.z);
            for lane in 0..LANES {
                let (dx, dy, dz) = (px - self.x[lane], py - self.y[lane], pz - self.z[lane]);
                let distance = dx * dx + dy * dy + dz * dz;
                let best = self.best[lane];
                let second = self.second[lane];
                let is_nearer = distance < best;
                let loser = if is_nearer { best } else { distance };
                self.second[lane] = if loser < second { loser } else { second };
                self.best[lane] = if is_nearer { distance } else { best };
                self.slot[lane] = if is_nearer { slot } else { self.slot[lane] };
            }
        }
    }

    #[inline(always)]
    fn found(&self, lane: usize, pruned_mm: f64) -> Found {
        let others = self.second[lane].sqrt().min(pruned_mm);
        let lead = (others - self.best[lane].sqrt()).max(0.0) * ROUNDED_DOWN_F32;
        #[expect(clippy::cast_possible_truncation, reason = "slots are u32, leads are bounds")]
        Found { slot: self.slot[lane] as u32, lead_mm: lead as f32 }
    }
}
