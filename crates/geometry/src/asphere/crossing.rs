use std::ops::ControlFlow;

use super::interval::Interval;
use super::{Asphere, root, upward_normal};
use crate::error::finite;
use crate::{GeometryError, Hit, Line};

/// Cells searched before the line is taken to lie in the surface.
const MAX_CELLS: u32 = 1 << 14;

/// Cells that wait while one is halved: at most one for each halving.
const MAX_DEPTH: usize = 64;

/// Below this sine of its angle to the axis, a line is parallel to it: any part ends long before.
const AXIAL: f64 = 1e-30;

/// Cells narrower than this share of the searched length hold a touching point or none.
const NARROWEST: f64 = 1e-9;

/// Height at which a line that does not cross still touches, as a share of the part's size.
const TOUCH: f64 = 1e-14;

/// A stretch of a line, by distance from its middle: `r² = square + 2 outward t + lateral t²`.
#[derive(Clone, Copy, Debug)]
struct Course {
    /// Distance of the middle along the line.
    middle: f64,
    /// Half the stretch's length.
    half: f64,
    square: f64,
    outward: f64,
    lateral: f64,
    /// Height at the middle, and its change along the line.
    z: f64,
    rise: f64,
}

impl Asphere {
    /// Calls `found` for every hit in the aperture at `start` or beyond, in order, until it breaks.
    ///
    /// Fails if there was none.
    pub(super) fn each_hit(
        &self,
        line: &Line,
        start: f64,
        found: &mut dyn FnMut(Hit) -> ControlFlow<()>,
    ) -> Result<(), GeometryError> {
        let course = self.course(line, start)?;
        let mut any = false;
        let mut nearest_miss = f64::INFINITY;
        self.roots(&course, &mut |t| {
            let hit = self.hit_at(line, course.middle + t);
            let (x, y) = (hit.point_mm.x, hit.point_mm.y);
            if !self.contains(x, y) {
                nearest_miss = nearest_miss.min(self.off_center(x, y));
                return ControlFlow::Continue(());
            }
            any = true;
            found(hit)
        })?;
        match (any, nearest_miss < f64::INFINITY) {
            (true, _) => Ok(()),
            (false, true) => Err(self.outside(nearest_miss)),
            (false, false) => Err(GeometryError::Misses),
        }
    }

    /// Part of the line from `start` on that is within the reach of the surface.
    fn course(&self, line: &Line, start: f64) -> Result<Course, GeometryError> {
        let Interval { lo, hi } = self.range(line)?;
        let lo = lo.max(start);
        if lo > hi {
            return Err(GeometryError::Misses);
        }
        let middle = 0.5 * (lo + hi);
        let (point, along) = (line.at(middle), line.direction.xy());
        let at = point.xy().coords;
        let course = Course {
            middle,
            half: 0.5 * (hi - lo),
            square: at.norm_squared(),
            outward: at.dot(&along),
            lateral: along.norm_squared(),
            z: point.z,
            rise: line.direction.z,
        };
        finite([&course.half, &course.square, &course.outward, &course.z], "line")?;
        Ok(course)
    }

    /// Part of the line in the cylinder around the surface, by distance along the line.
    fn range(&self, line: &Line) -> Result<Interval, GeometryError> {
        let (at, along) = (line.point_mm.coords.xy(), line.direction.xy());
        finite([&at.norm_squared(), &line.point_mm.z, &line.direction.norm()], "line")?;
        let lateral = along.norm();
        let axial = lateral < AXIAL;
        let nearest = if axial { at.norm() } else { (at.perp(&along) / lateral).abs() };
        let room = (self.reach - nearest) * (self.reach + nearest);
        if room < 0.0 {
            let limit_mm = self.profile.limit();
            return Err(if nearest >= limit_mm {
                GeometryError::SagUndefined { radius_mm: nearest, limit_mm }
            } else {
                self.outside(nearest)
            });
        }
        let mut range = Interval { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
        if !axial {
            let (center, half) = (-at.dot(&along) / (lateral * lateral), room.sqrt() / lateral);
            range = Interval { lo: center - half, hi: center + half };
        }
        if line.direction.z != 0.0 {
            // Well clear of the round-off of the heights.
            let slack = 0.5 * self.height.width() + 1e-6 * self.reach;
            let to_height = |z: f64| (z - line.point_mm.z) / line.direction.z;
            let slab = Interval::between(
                to_height(self.height.lo - slack),
                to_height(self.height.hi + slack),
            );
            range = Interval { lo: range.lo.max(slab.lo), hi: range.hi.min(slab.hi) };
        }
        Ok(range)
    }

    /// Calls `found` for each root of height over the surface, ascending.
    fn roots(
        &self,
        course: &Course,
        found: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<(), GeometryError> {
        let range = Interval { lo: -course.half, hi: course.half };
        let narrowest = NARROWEST * range.width();
        let mut waiting = [Interval::point(0.0); MAX_DEPTH];
        waiting[0] = range;
        let mut depth = 1;
        let mut last = f64::NEG_INFINITY;
        for _ in 0..MAX_CELLS {
            if depth == 0 {
                return Ok(());
            }
            depth -= 1;
            let cell = waiting[depth];
            let root = match self.verdict(course, cell) {
                Verdict::NoRoot => None,
                Verdict::Monotone => self.crossing(course, cell),
                Verdict::Undecided if cell.width() <= narrowest => self.touch(course, cell),
                Verdict::Undecided => {
                    let [before, after] = cell.halves();
                    waiting[depth..depth + 2].copy_from_slice(&[after, before]);
                    depth += 2;
                    None
                }
            };
            // Neighbouring cells share a root on their border.
            if let Some(root) = root.filter(|root| root - last > 2.0 * narrowest) {
                last = root;
                if found(root).is_break() {
                    return Ok(());
                }
            }
        }
        Err(GeometryError::LineInSurface)
    }

    fn verdict(&self, course: &Course, cell: Interval) -> Verdict {
        let over = self.profile.jet_over(self.within_reach(course.square_over(cell)));
        let height = cell.scale(course.rise) + Interval::point(course.z) + over.z.scale(-1.0);
        let margin = 8.0 * f64::EPSILON * (course.z.abs() + over.z.magnitude());
        if !height.contains_zero(margin) {
            return Verdict::NoRoot;
        }
        let square_rate = (cell.scale(course.lateral) + Interval::point(course.outward)).scale(2.0);
        let rate = Interval::point(course.rise) + (over.dz * square_rate).scale(-1.0);
        if rate.contains_zero(0.0) { Verdict::Undecided } else { Verdict::Monotone }
    }

    fn crossing(&self, course: &Course, cell: Interval) -> Option<f64> {
        let height = |t| self.height_over(course, t);
        let (before, after) = (height(cell.lo).0, height(cell.hi).0);
        let crosses = before <= 0.0 && after >= 0.0 || before >= 0.0 && after <= 0.0;
        crosses.then(|| root::bracketed(height, cell.lo, cell.hi, cell.midpoint()))
    }

    /// Where in a cell without direction the line touches the surface, if it does.
    fn touch(&self, course: &Course, cell: Interval) -> Option<f64> {
        let size = self.reach + self.height.magnitude() + course.z.abs();
        let middle = cell.midpoint();
        (self.height_over(course, middle).0.abs() <= TOUCH * size).then_some(middle)
    }

    /// Height of the line over the surface, and its rate.
    fn height_over(&self, course: &Course, t: f64) -> (f64, f64) {
        let jet = self.profile.jet(course.square_at(t).clamp(0.0, self.reach * self.reach));
        let rate = course.rise - jet.dz * 2.0 * (course.outward + course.lateral * t);
        (course.z + course.rise * t - jet.z, rate)
    }

    /// Round-off must not carry a cell past the conic's end.
    fn within_reach(&self, square: Interval) -> Interval {
        let most = self.reach * self.reach;
        Interval { lo: square.lo.clamp(0.0, most), hi: square.hi.clamp(0.0, most) }
    }

    fn hit_at(&self, line: &Line, distance_mm: f64) -> Hit {
        let point_mm = line.at(distance_mm);
        let square = point_mm.x * point_mm.x + point_mm.y * point_mm.y;
        let twice_dz = 2.0 * self.profile.jet(square.min(self.reach * self.reach)).dz;
        let normal = upward_normal(twice_dz * point_mm.x, twice_dz * point_mm.y);
        Hit { distance_mm, point_mm, normal }
    }
}

impl Course {
    fn square_at(&self, t: f64) -> f64 {
        self.square + t * (2.0 * self.outward + self.lateral * t)
    }

    fn square_over(&self, t: Interval) -> Interval {
        let ends = Interval::between(self.square_at(t.lo), self.square_at(t.hi));
        // Where the line is closest to the axis; NaN for a line parallel to it, and then unused.
        let nearest = -self.outward / self.lateral;
        let inside = t.lo < nearest && nearest < t.hi;
        Interval { lo: if inside { self.square_at(nearest) } else { ends.lo }, hi: ends.hi }
    }
}

enum Verdict {
    NoRoot,
    Monotone,
    Undecided,
}
