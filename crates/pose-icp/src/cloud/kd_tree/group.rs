//! Nearest points of many neighbouring queries.

#![expect(
    clippy::inline_always,
    reason = "inlined into functions that are compiled for wide registers"
)]

use nalgebra::Point3;

use super::boxes::{Aabb, OuterBox};
use super::build::LANES;
use super::found::{Found, NONE};
use super::lanes::{Lanes, SINGLE_ERROR};
use super::tree::KdTree;
use super::wide::WIDTH;

/// Siblings that wait on each level of the tallest tree: 2^32 points.
const MAX_STACK: usize = 80;

/// Covers the rounding of a few operations, in squared distances too.
const ROUNDED_UP: f64 = 1.0 + 1e-14;

/// The same for single precision.
const ROUNDED_UP_F32: f32 = 1.0 + 3e-7;

/// The same downwards.
const ROUNDED_DOWN_F32: f64 = 1.0 - 2e-7;

impl KdTree {
    /// Finds the nearest point of each query within `limit_mm`.
    ///
    /// Queries should be neighbours of one another. What `found` holds already serves as a hint.
    /// Points that are further than the nearest by less than `margin_mm` are looked at too, so
    /// that leads up to that are seen. `far_off` may know of the queries in a box, and of the slot found
    /// for a neighbour of theirs, that none of them needs to be answered: then the value is the lead
    /// of «nothing».
    #[inline(always)]
    pub(crate) fn search(
        &self,
        queries: &[Point3<f64>],
        limit_mm: f64,
        margin_mm: f64,
        found: &mut [Found],
        far_off: impl Fn(&Aabb, Option<u32>) -> Option<f32>,
    ) {
        let mut near = None;
        for (queries, found) in queries.chunks(LANES).zip(found.chunks_mut(LANES)) {
            let aabb = Aabb::of(queries);
            if found.iter().all(|f| f.slot == NONE)
                && let Some(lead_mm) = far_off(&aabb, near)
            {
                found.fill(Found { slot: NONE, lead_mm });
                continue;
            }
            let reach = self.reach(queries, found, near, limit_mm);
            let mut lanes = Lanes::new(queries, &self.nodes.corner, self.extent_mm);
            let is_hinted = found.iter().all(|f| f.slot != NONE);
            let pruned = self.walk(&aabb, &mut lanes, reach, is_hinted, margin_mm);
            for (lane, (query, found)) in queries.iter().zip(&mut *found).enumerate() {
                *found = self.decide(query, &lanes, lane, limit_mm, pruned);
            }
            near = found.iter().rev().find(|f| f.slot != NONE).map(|f| f.slot).or(near);
        }
    }

    /// Distance within which every query of a group has a point, if it has one within the limit.
    #[inline(always)]
    fn reach(
        &self,
        queries: &[Point3<f64>],
        found: &[Found],
        near: Option<u32>,
        limit_mm: f64,
    ) -> f64 {
        let mut reach_squared = 0.0_f64;
        for (query, found) in queries.iter().zip(found) {
            let hint = if found.slot == NONE { near } else { Some(found.slot) };
            let Some(hint) = hint else { return limit_mm };
            let squared = (self.points[hint as usize] - query).norm_squared();
            reach_squared = if squared > reach_squared { squared } else { reach_squared };
        }
        reach_squared.sqrt().min(limit_mm)
    }

    /// What a lane found, exactly.
    #[inline(always)]
    fn decide(
        &self,
        query: &Point3<f64>,
        lanes: &Lanes,
        lane: usize,
        limit_mm: f64,
        pruned_mm: f64,
    ) -> Found {
        let slot = lanes.slot[lane];
        if slot == NONE {
            // The limit kept the search from looking further.
            return Found { slot, lead_mm: lead(pruned_mm - limit_mm) };
        }
        let (slot, best_mm, others_mm) = if let Some((_, second_mm)) = lanes.told_apart(lane) {
            let best_mm = (self.points[slot as usize] - query).norm();
            (slot, best_mm, second_mm * (1.0 - SINGLE_ERROR) - lanes.error_mm)
        } else {
            let bound_mm = f64::from(lanes.best[lane]).sqrt() * (1.0 + SINGLE_ERROR);
            self.nearest_two(query, bound_mm + 2.0 * lanes.error_mm)
        };
        if best_mm >= limit_mm {
            return Found { slot: NONE, lead_mm: lead(best_mm.min(pruned_mm) - limit_mm) };
        }
        Found { slot, lead_mm: lead(others_mm.min(pruned_mm) - best_mm) }
    }

    /// Slot and distance of the nearest point, which must lie within the bound, and distance of the
    /// next, or the bound if that is less.
    #[cold]
    #[inline(never)]
    fn nearest_two(&self, query: &Point3<f64>, bound_mm: f64) -> (u32, f64, f64) {
        let bound_mm = bound_mm * ROUNDED_UP;
        let here = OuterBox::of(&Aabb::of(std::slice::from_ref(query)), &self.nodes.corner);
        let radius = Radius::new(bound_mm);
        let (mut slot, mut best, mut second) = (NONE, f64::INFINITY, bound_mm * bound_mm);
        let mut waiting = vec![(0, 0)];
        while let Some((level, n)) = waiting.pop() {
            let gaps = self.nodes.node(level, n).gaps_squared(&here);
            for child in (0..self.nodes.width(level)).filter(|&c| gaps[c] < radius.squared) {
                let below = self.nodes.below(level, n, child);
                if level + 1 < self.nodes.n_levels() {
                    waiting.push((level + 1, below));
                    continue;
                }
                for at in self.leaf(below) {
                    let squared = (self.points[at] - query).norm_squared();
                    second = second.min(squared.max(best));
                    if squared < best {
                        #[expect(clippy::cast_possible_truncation, reason = "below 2^32")]
                        let at = at as u32;
                        (slot, best) = (at, squared);
                    }
                }
            }
        }
        (slot, best.sqrt(), second.sqrt())
    }

    /// Looks at every leaf within reach; returns the distance beyond which nothing was looked at.
    #[inline(always)]
    fn walk(
        &self,
        aabb: &Aabb,
        lanes: &mut Lanes,
        reach: f64,
        is_near: bool,
        margin_mm: f64,
    ) -> f64 {
        let outer = OuterBox::of(aabb, &self.nodes.corner);
        let center = outer.center();
        let middle = OuterBox { min: center, max: center };
        let lowest = self.nodes.n_levels() - 1;
        let mut radius = Radius::new((reach + margin_mm) * ROUNDED_UP);
        let mut stack = [Waiting { gap: 0.0, level: 0, node: 0 }; MAX_STACK];
        let mut height = 1;
        let mut is_near = is_near;
        while height > 0 {
            height -= 1;
            let Waiting { gap, level, node: n } = stack[height];
            if gap >= radius.squared {
                continue;
            }
            let node = self.nodes.node(level as usize, n as usize);
            let gaps = node.gaps_squared(&outer);
            let mut within = 0_u32;
            for (child, &gap) in gaps.iter().enumerate() {
                within |= u32::from(gap < radius.squared) << child;
            }
            if !is_near && !within.is_power_of_two() && within != 0 {
                // The nearest comes first, and the others wait: it shrinks what is within reach.
                let from_center = node.gaps_squared(&middle);
                let mut nearest = first(within);
                let mut rest = within & (within - 1);
                while rest != 0 {
                    let child = first(rest);
                    rest &= rest - 1;
                    let is_nearer = from_center[child] < from_center[nearest];
                    nearest = if is_nearer { child } else { nearest };
                }
                within &= !(1 << nearest);
                if level as usize == lowest {
                    self.scan_leaf(n as usize, nearest, lanes, &mut radius, margin_mm);
                    is_near = true;
                } else {
                    let mut rest = within;
                    while rest != 0 {
                        let child = first(rest);
                        rest &= rest - 1;
                        stack[height] = self.waiting(level, n, child, gaps[child]);
                        height += 1;
                    }
                    stack[height] = self.waiting(level, n, nearest, gaps[nearest]);
                    height += 1;
                    continue;
                }
            }
            while within != 0 {
                let child = first(within);
                within &= within - 1;
                if level as usize != lowest {
                    stack[height] = self.waiting(level, n, child, gaps[child]);
                    height += 1;
                } else if gaps[child] < radius.squared {
                    self.scan_leaf(n as usize, child, lanes, &mut radius, margin_mm);
                    is_near = true;
                }
            }
        }
        radius.mm
    }

    #[inline(always)]
    fn scan_leaf(
        &self,
        n: usize,
        child: usize,
        lanes: &mut Lanes,
        radius: &mut Radius,
        margin_mm: f64,
    ) {
        let lowest = self.nodes.n_levels() - 1;
        let slots = self.leaf(self.nodes.below(lowest, n, child));
        lanes.scan(&self.single[slots.clone()], slots.start);
        let worst = lanes.worst();
        if worst < radius.worst {
            radius.worst = worst;
            radius.shrink((lanes.distance_mm(worst) + margin_mm) * ROUNDED_UP);
        }
    }

    #[inline(always)]
    fn waiting(&self, level: u32, n: u32, child: usize, gap: f32) -> Waiting {
        #[expect(clippy::cast_possible_truncation, reason = "below 2^32 nodes")]
        let node = self.nodes.below(level as usize, n as usize, child) as u32;
        Waiting { gap, level: level + 1, node }
    }
}

/// A bound on a lead, in single precision.
#[inline(always)]
fn lead(lead_mm: f64) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "rounded down")]
    let lead_mm = (lead_mm.max(0.0) * ROUNDED_DOWN_F32) as f32;
    lead_mm
}

/// The lowest bit that is set.
#[inline(always)]
fn first(bits: u32) -> usize {
    bits.trailing_zeros() as usize % WIDTH
}

/// A node that may be within reach.
#[derive(Clone, Copy)]
struct Waiting {
    gap: f32,
    level: u32,
    node: u32,
}

/// Distance within which points matter.
struct Radius {
    mm: f64,
    /// Rounded up.
    squared: f32,
    /// Squared distance of the lane that it comes from.
    worst: f32,
}

impl Radius {
    #[inline(always)]
    fn new(mm: f64) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "rounded up")]
        let squared = (mm * mm) as f32;
        let squared = (squared * ROUNDED_UP_F32).max(f32::MIN_POSITIVE);
        Self { mm, squared, worst: f32::INFINITY }
    }

    #[inline(always)]
    fn shrink(&mut self, mm: f64) {
        if mm < self.mm {
            *self = Self { worst: self.worst, ..Self::new(mm) };
        }
    }
}
