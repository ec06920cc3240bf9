use std::ops::ControlFlow;

use nalgebra::{Matrix2, Vector2, Vector3};

use super::Nurbs;
use super::patch::Leaf;
use crate::error::finite;
use crate::{GeometryError, Hit, Line};

const MAX_STEPS: usize = 40;
/// Steps below this share of the part leave, squared, no error.
const LAST_STEP: f64 = 1e-9;
/// Sine between line and surface below which they are tangent.
const TANGENT: f64 = 1e-9;

impl Nurbs {
    /// Visits every hit of a line, in no order; one on the border of leaves is visited from each.
    pub(super) fn each_hit(
        &self,
        line: &Line,
        visit: &mut impl FnMut(Hit) -> ControlFlow<()>,
    ) -> Result<(), GeometryError> {
        finite(line.point_mm.iter(), "point of the line")?;
        let mut in_surface = false;
        let _ = self.tree.each_met(line, &mut |leaf: &Leaf| {
            for start in std::iter::once(leaf.middle()).chain(leaf.quarters()) {
                match self.meeting(line, leaf, start) {
                    Some(Meeting::At(hit)) => visit(hit)?,
                    Some(Meeting::Within) => {
                        in_surface = true;
                        return ControlFlow::Break(());
                    }
                    None => {}
                }
            }
            ControlFlow::Continue(())
        });
        if in_surface { Err(GeometryError::LineInSurface) } else { Ok(()) }
    }

    /// Newton's method on the two distances across the line, from a place in a leaf.
    fn meeting(&self, line: &Line, leaf: &Leaf, start: [f64; 2]) -> Option<Meeting> {
        let direction = line.direction.into_inner();
        let first = direction.cross(&Vector3::ith(direction.iamin(), 1.0)).normalize();
        let across = [first, direction.cross(&first)];
        let mut at = Vector2::from(start);
        for _ in 0..MAX_STEPS {
            let jet = self.jet_at(at.into());
            let arm = jet.point_mm - line.point_mm;
            let gap = Vector2::new(across[0].dot(&arm), across[1].dot(&arm));
            let slope = Matrix2::from_fn(|i, j| across[i].dot(&jet.tangents_mm[j]));
            // Along a line in the surface any step does: the least one.
            let step = -slope.svd(true, true).solve(&gap, TANGENT * slope.norm()).ok()?;
            let next = at + step;
            // A leaf is nearly flat: from within it, what leads far away meets another leaf.
            let room = |d: usize| {
                let [from, to] = leaf.domain[d];
                (from - (to - from)..=to + (to - from)).contains(&next[d])
            };
            if !(room(0) && room(1)) {
                return None;
            }
            at = next;
            if jet.moved(&step).norm() < LAST_STEP * self.tree.reach_mm() {
                let met = gap.norm() < 2.0 * LAST_STEP * self.tree.reach_mm();
                return if met && leaf.holds(at.into()) { self.hit(line, at.into()) } else { None };
            }
        }
        None
    }

    fn hit(&self, line: &Line, at: [f64; 2]) -> Option<Meeting> {
        let jet = self.jet_at(at);
        let normal = self.normal_of(&jet, at).ok()?;
        let distance_mm = line.direction.dot(&(jet.point_mm - line.point_mm));
        if normal.dot(&line.direction).abs() < TANGENT {
            return Some(Meeting::Within);
        }
        Some(Meeting::At(Hit { distance_mm, point_mm: jet.point_mm, normal }))
    }
}

/// How a line meets a leaf.
enum Meeting {
    At(Hit),
    /// Along it.
    Within,
}
