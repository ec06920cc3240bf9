use super::Asphere;
use super::interval::Interval;
use super::profile::Meridian;
use super::root;
use crate::GeometryError;

/// A foot is refused where the round-off of the query is magnified more than a million times.
const MIN_STIFFNESS: f64 = 1e-6;

/// Feet whose distances differ by less than this share of the distance or the aperture tie.
const TIE: f64 = 1e-10;

/// A foot within this share of the least radius of curvature needs no search for a rival.
const CERTAIN_SHARE: f64 = 0.999;

/// Newton steps below this share of the smallest length in the problem leave, squared, no error.
const LAST_STEP: f64 = 1e-5;

/// What a Newton step may leave, as a share of the same length, for it to be the last.
const LEFT_OVER: f64 = 1e-15;

/// Steps before the quick way gives up; from the query's own radius three or four suffice.
const MAX_STEPS: u32 = 12;

/// Cells searched before the query is taken for one near a centre of curvature.
const MAX_CELLS: u32 = 1 << 14;

/// Cells that wait while one is halved: at most one for each halving.
const MAX_DEPTH: usize = 64;

/// Foot in the half-plane through axis and query.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeridianFoot {
    pub(super) r: f64,
    pub(super) z: f64,
    pub(super) slope: f64,
    /// Length of `(slope, 1)`.
    pub(super) stretch: f64,
    pub(super) signed_distance: f64,
}

/// The distance from a query to the meridian as a function of `r`.
#[derive(Clone, Copy, Debug)]
struct Query<'a> {
    asphere: &'a Asphere,
    radius: f64,
    z: f64,
}

/// Best foot so far and its closest rival.
#[derive(Clone, Copy, Debug)]
struct Search {
    /// Distance that any better foot must undercut.
    bound: f64,
    best: Option<(f64, f64)>,
    rival: f64,
}

impl Asphere {
    /// Closest point of the meridian, `radius ≥ 0` being the query's distance from the axis.
    ///
    /// The closest point of a surface of revolution lies in the query's own half-plane.
    pub(super) fn meridian_foot(&self, radius: f64, z: f64) -> Result<MeridianFoot, GeometryError> {
        let query = Query { asphere: self, radius, z };
        let quick = query.newton();
        // A graph whose curvature stays below κ has one single foot for every query that has a foot
        // closer than 1/κ: it cannot bend back into the ball (docs/geometry.md).
        match quick {
            Some(foot) if foot.signed_distance.abs() * self.max_curvature < CERTAIN_SHARE => {
                Ok(foot)
            }
            _ => query.search(quick),
        }
    }
}

impl Query<'_> {
    /// Newton's method from the query's own radius; `None` if it leaves the reach or the minimum.
    fn newton(&self) -> Option<MeridianFoot> {
        let reach = self.asphere.reach;
        let smallest = (1.0 / self.asphere.max_curvature).min(reach);
        let mut r = self.radius.min(reach);
        let mut finished = false;
        let mut before: Option<(f64, f64)> = None;
        for _ in 0..MAX_STEPS {
            let at = self.asphere.profile.meridian(r);
            let (value, stiffness) = self.derivatives(r, &at);
            if stiffness.is_nan() || stiffness <= 0.0 {
                return None;
            }
            let step = -value / stiffness;
            // What the step leaves, from how the derivative bent over the one before.
            let left = before.map_or(f64::INFINITY, |(r_before, stiffness_before)| {
                let bent = (stiffness - stiffness_before) / (r - r_before);
                (0.5 * bent / stiffness * step * step).abs()
            });
            if finished || (step.abs() < LAST_STEP * smallest && left < LEFT_OVER * smallest) {
                // The step is small to the second order, so the surface along it is a parabola.
                let z = at.z + step * (at.slope + 0.5 * step * at.bend);
                return Some(self.foot((r + step).max(0.0), z, at.slope + step * at.bend));
            }
            before = Some((r, stiffness));
            let next = r + step;
            if next > reach && r >= reach {
                return None;
            }
            r = next.clamp(0.0, reach);
            finished = step.abs() < LAST_STEP * smallest;
        }
        None
    }

    /// `½ d(distance²)/dr = (r − r_q) + (z − z_q) z'` and its derivative.
    fn derivatives(&self, r: f64, at: &Meridian<f64>) -> (f64, f64) {
        let gap = at.z - self.z;
        ((r - self.radius) + gap * at.slope, 1.0 + at.slope * at.slope + gap * at.bend)
    }

    fn foot(&self, r: f64, z: f64, slope: f64) -> MeridianFoot {
        let along_normal = (self.z - z) - slope * (self.radius - r);
        let stretch = (1.0 + slope * slope).sqrt();
        MeridianFoot { r, z, slope, stretch, signed_distance: along_normal / stretch }
    }

    fn distance(&self, r: f64, z: f64) -> f64 {
        (r - self.radius).hypot(z - self.z)
    }

    /// Branch and bound over the whole reach: every foot is found or excluded.
    fn search(&self, quick: Option<MeridianFoot>) -> Result<MeridianFoot, GeometryError> {
        let reach = self.asphere.reach;
        let edge = self.distance(reach, self.asphere.profile.meridian(reach).z);
        let mut search = Search { bound: edge, best: None, rival: f64::INFINITY };
        if let Some(foot) = quick {
            search.offer(foot.r, self.distance(foot.r, foot.z), reach);
        }
        self.branch(&mut search)?;
        let Some((r, distance)) = search.best else {
            return Err(self.asphere.outside(reach));
        };
        let tie = TIE * distance.max(reach);
        if edge < distance - tie {
            return Err(self.asphere.outside(reach));
        }
        let at = self.asphere.profile.meridian(r);
        let foot = self.foot(r, at.z, at.slope);
        let stretch = at.slope.hypot(1.0);
        let meridional = self.derivatives(r, &at).1 / (stretch * stretch);
        let sagittal_curvature = 2.0 * self.asphere.profile.jet(r * r).dz / stretch;
        let sagittal = 1.0 - foot.signed_distance * sagittal_curvature;
        let stiff = meridional >= MIN_STIFFNESS && sagittal >= MIN_STIFFNESS;
        if !stiff || search.rival <= distance + tie {
            return Err(GeometryError::AmbiguousFoot { distance_mm: distance });
        }
        Ok(foot)
    }

    fn branch(&self, search: &mut Search) -> Result<(), GeometryError> {
        let reach = self.asphere.reach;
        let narrowest = 1e-10 * reach;
        let mut waiting = [Interval::point(0.0); MAX_DEPTH];
        waiting[0] = Interval::between(0.0, reach);
        let mut depth = 1;
        for _ in 0..MAX_CELLS {
            if depth == 0 {
                return Ok(());
            }
            depth -= 1;
            let cell = waiting[depth];
            let over = self.asphere.profile.meridian_over(cell);
            if self.box_distance(cell, over.z) > search.bound + TIE * search.bound.max(reach) {
                continue;
            }
            match self.verdict(cell, &over) {
                Verdict::NoFoot => {}
                Verdict::AtMostOneFoot => self.refine(cell, search),
                Verdict::Undecided if cell.width() < narrowest => {
                    return Err(GeometryError::AmbiguousFoot { distance_mm: search.bound });
                }
                Verdict::Undecided => {
                    let [inner, outer] = cell.halves();
                    let inner_first = self.radius < cell.midpoint();
                    waiting[depth..depth + 2].copy_from_slice(&if inner_first {
                        [outer, inner]
                    } else {
                        [inner, outer]
                    });
                    depth += 2;
                }
            }
        }
        Err(GeometryError::AmbiguousFoot { distance_mm: search.bound })
    }

    fn box_distance(&self, r: Interval, z: Interval) -> f64 {
        let outside = |at: f64, range: Interval| (range.lo - at).max(at - range.hi).max(0.0);
        outside(self.radius, r).hypot(outside(self.z, z))
    }

    fn verdict(&self, r: Interval, over: &Meridian<Interval>) -> Verdict {
        let gap = over.z + Interval::point(-self.z);
        let value = r + Interval::point(-self.radius) + gap * over.slope;
        let scale = self.radius + self.asphere.reach + gap.magnitude() * over.slope.magnitude();
        if !value.contains_zero(8.0 * f64::EPSILON * scale) {
            return Verdict::NoFoot;
        }
        let stiffness = Interval::point(1.0) + over.slope.square() + gap * over.bend;
        if stiffness.hi < 0.0 {
            Verdict::NoFoot
        } else if stiffness.lo > 0.0 {
            Verdict::AtMostOneFoot
        } else {
            Verdict::Undecided
        }
    }

    /// Looks for the one foot of a cell in which the derivative rises throughout.
    fn refine(&self, cell: Interval, search: &mut Search) {
        let derivatives = |r| self.derivatives(r, &self.asphere.profile.meridian(r));
        if derivatives(cell.lo).0 <= 0.0 && derivatives(cell.hi).0 >= 0.0 {
            let r = root::bracketed(derivatives, cell.lo, cell.hi, self.radius);
            let distance = self.distance(r, self.asphere.profile.meridian(r).z);
            search.offer(r, distance, self.asphere.reach);
        }
    }
}

/// What bounds over a cell say of feet in it.
enum Verdict {
    NoFoot,
    AtMostOneFoot,
    Undecided,
}

impl Search {
    /// Takes a foot into account; the same foot may come several times.
    fn offer(&mut self, r: f64, distance: f64, reach: f64) {
        match self.best {
            Some((known, _)) if (known - r).abs() < 1e-9 * reach => return,
            Some((_, shortest)) if distance >= shortest => self.rival = self.rival.min(distance),
            Some((_, shortest)) => {
                self.rival = shortest;
                self.best = Some((r, distance));
            }
            None => self.best = Some((r, distance)),
        }
        self.bound = self.bound.min(distance);
    }
}
