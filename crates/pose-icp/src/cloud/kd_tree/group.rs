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
            let pruned = self.walk(&aabb, &mut lanes, reach, margin_mm);
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
    fn walk(&self, aabb: &Aabb, lanes: &mut Lanes, reach: f64, margin_mm: f64) -> f64 {
        let outer = OuterBox::of(aabb, &self.nodes.corner);
        let center = outer.center();
        let middle = OuterBox { min: center, max: center };
        let lowest = self.nodes.n_levels() - 1;
        let mut radius = Radius::new((reach + margin_mm) * ROUNDED_UP);
        let mut stack = [Waiting { gap: 0.0, level: 0, node: 0 }; MAX_STACK];
        let mut height = 1;
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
            let mut order = [0_u8; WIDTH];
            let mut n_within = 0;
            if within.is_power_of_two() {
                order[0] = first(within);
                n_within = 1;
            } else if within != 0 {
                let from_center = node.gaps_squared(&middle);
                while within != 0 {
                    let child = first(within);
                    within &= within - 1;
                    let key = from_center[child as usize];
                    let mut at = n_within;
                    while at > 0 && from_center[order[at - 1] as usize] > key {
                        order[at] = order[at - 1];
                        at -= 1;
                    }
                    order[at] = child;
                    n_within += 1;
                }
            }
            if level as usize == lowest {
                for &child in &order[..n_within] {
                    if gaps[child as usize] >= radius.squared {
                        continue;
                    }
                    let leaf = self.nodes.below(lowest, n as usize, child as usize);
                    let slots = self.leaf(leaf);
                    lanes.scan(&self.single[slots.clone()], slots.start);
                    radius.shrink((lanes.worst_mm() + margin_mm) * ROUNDED_UP);
                }
            } else {
                for &child in order[..n_within].iter().rev() {
                    #[expect(clippy::cast_possible_truncation, reason = "below 2^32 nodes")]
                    let node = self.nodes.below(level as usize, n as usize, child as usize) as u32;
                    stack[height] = Waiting { gap: gaps[child as usize], level: level + 1, node };
                    height += 1;
                }
            }
        }
        radius.mm
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
#[expect(clippy::cast_possible_truncation, reason = "of eight")]
#[inline(always)]
fn first(bits: u32) -> u8 {
    bits.trailing_zeros() as u8
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
}

impl Radius {
    #[inline(always)]
    fn new(mm: f64) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "rounded up")]
        let squared = (mm * mm) as f32;
        Self { mm, squared: (squared * ROUNDED_UP_F32).max(f32::MIN_POSITIVE) }
    }

    #[inline(always)]
    fn shrink(&mut self, mm: f64) {
        if mm < self.mm {
            *self = Self::new(mm);
        }
    }
}
