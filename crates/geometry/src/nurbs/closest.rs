use nalgebra::{Matrix2, Point3, Unit, Vector2, Vector3};

use super::jet::NurbsJet;
use super::{Nurbs, SAME_SHARE};
use crate::error::finite;
use crate::{Foot, GeometryError};

/// Steps of one search.
const MAX_STEPS: usize = 60;
/// Steps below this share of the lengths in the problem leave, squared, no error.
const LAST_STEP: f64 = 1e-9;
/// Steps below this share converge by themselves.
const SURE_STEP: f64 = 1e-4;
/// A foot is refused where the round-off of the query is magnified more than a million times.
const MIN_STIFFNESS: f64 = 1e-6;
/// Below this stiffness a leaf may hold a second foot, and is searched from four more places.
const SOFT: f64 = 0.5;
/// Share of the lengths in the problem by which round-off may decide between two feet.
const TIE_SHARE: f64 = 1e-11;
/// Share of the lengths in the problem by which the query may be beside the normal of its foot: near
/// a pole, where one tangent all but vanishes, descents end no better.
const FOOT_SHARE: f64 = 1e-8;
/// Determinant over squared trace of the metric, over the whole of u and v, below which an edge has
/// all but collapsed: one tangent is a millionth of the other, and round-off of the Hessian is a
/// thousandth of its square.
const COLLAPSED: f64 = 1e-12;

/// A place whose neighbours are all farther.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest {
    pub(super) at: [f64; 2],
    point_mm: Point3<f64>,
    distance_mm: f64,
    /// Distance of the query's projection along the surface: that beyond an edge, or zero.
    beside_mm: f64,
    /// The smaller of `1 − κ d`.
    stiffness: f64,
    inside: bool,
}

/// All feet so far that may count.
struct Search<'a> {
    surface: &'a Nurbs,
    query_mm: &'a Point3<f64>,
    /// Lengths in the problem.
    scale_mm: f64,
    best: Option<Nearest>,
    /// Distance to the next best place.
    rival_mm: f64,
}

impl Nurbs {
    /// The nearest of all feet.
    pub(super) fn nearest(&self, query_mm: &Point3<f64>) -> Result<Nearest, GeometryError> {
        finite([&query_mm.coords.norm_squared()], "query point")?;
        let scale_mm = self.tree.reach_mm() + query_mm.coords.amax();
        let mut search =
            Search { surface: self, query_mm, scale_mm, best: None, rival_mm: f64::INFINITY };
        self.tree.each_near(query_mm, &mut |leaf| {
            search.offer(leaf.middle());
            if search.best.is_some_and(|best| best.stiffness < SOFT) {
                leaf.quarters().into_iter().for_each(|at| search.offer(at));
            }
            search.within_mm()
        });
        let none = GeometryError::AmbiguousFoot { distance_mm: search.within_mm() };
        let best = search.best.ok_or(none)?;
        let distance_mm = best.distance_mm;
        if best.beside_mm > FOOT_SHARE * scale_mm && self.is_at_edge(best.at) {
            let (distance_mm, aperture_radius_mm) = (best.beside_mm, self.tree.reach_mm());
            return Err(GeometryError::OutsideAperture { distance_mm, aperture_radius_mm });
        }
        let tied = search.rival_mm - distance_mm <= TIE_SHARE * scale_mm;
        // Nearest on a crease, whose two sides have normals of their own.
        let is_no_foot = best.beside_mm > FOOT_SHARE * scale_mm;
        if tied || is_no_foot || best.stiffness < MIN_STIFFNESS {
            return Err(GeometryError::AmbiguousFoot { distance_mm });
        }
        Ok(best)
    }

    pub(super) fn foot(&self, query_mm: &Point3<f64>) -> Result<Foot, GeometryError> {
        let nearest = self.nearest(query_mm)?;
        let normal = self.normal_of(&self.jet_at(nearest.at), nearest.at)?;
        let signed_distance_mm = normal.dot(&(query_mm - nearest.point_mm));
        let (point_mm, inside_aperture) = (nearest.point_mm, nearest.inside);
        Ok(Foot { point_mm, normal, signed_distance_mm, inside_aperture })
    }

    /// Beginning and end of a direction with its margins.
    fn widened(&self, direction: usize) -> [f64; 2] {
        let ([from, to], [before, after]) =
            (self.net.knots[direction].domain(), self.margins[direction]);
        [from - before, to + after]
    }

    fn is_inside(&self, at: [f64; 2]) -> bool {
        (0..2).all(|d| {
            let [from, to] = self.net.knots[d].domain();
            let slack = SAME_SHARE * (to - from);
            (from - slack..=to + slack).contains(&at[d])
        })
    }

    fn has_collapsed(&self, metric: &Matrix2<f64>) -> bool {
        let lengths = self.domain().map(|[from, to]| to - from);
        let whole = Matrix2::from_fn(|i, j| lengths[i] * metric[(i, j)] * lengths[j]);
        whole.determinant() <= COLLAPSED * whole.trace().powi(2)
    }

    fn is_at_edge(&self, at: [f64; 2]) -> bool {
        (0..2).any(|d| {
            let [from, to] = self.widened(d);
            at[d] <= from || at[d] >= to
        })
    }

    /// Whether a place is on an edge that is none: a seam, or a pole.
    fn goes_on(&self, at: [f64; 2]) -> bool {
        (0..2).any(|d| {
            let ([from, to], [before, after]) = (self.net.knots[d].domain(), self.margins[d]);
            (at[d] <= from && before == 0.0) || (at[d] >= to && after == 0.0)
        })
    }

    /// Newton's method on half the squared distance, within the edges.
    fn descend(&self, query: &Point3<f64>, start: [f64; 2], scale_mm: f64) -> Option<Nearest> {
        let mut at = Vector2::from(start);
        let mut jet = self.jet_at(start);
        let mut cost = half_square(query, &jet);
        for _ in 0..MAX_STEPS {
            let slope = Slope::new(self, query, &at, &jet);
            let (step, exact) = slope.step();
            let (next, jet_there, cost_there, length) =
                self.shortened(query, &at, &step, cost, &jet)?;
            let length = length / scale_mm;
            if exact && length < LAST_STEP {
                return Some(self.concluded(query, next, jet_there));
            }
            if cost_there < cost || (exact && length < SURE_STEP) {
                (at, jet, cost) = (next, jet_there, cost_there);
            } else {
                // No step is closer.
                return Some(self.concluded(query, at, jet));
            }
        }
        None
    }

    /// The first of the step, its half, … that is closer or too short for its gain to show; where
    /// there is none, the last.
    fn shortened(
        &self,
        query: &Point3<f64>,
        at: &Vector2<f64>,
        step: &Vector2<f64>,
        before: f64,
        jet: &NurbsJet,
    ) -> Option<(Vector2<f64>, NurbsJet, f64, f64)> {
        const HALVINGS: i32 = 40;
        let scale = 1.0 + jet.point_mm.coords.amax() + query.coords.amax();
        let mut last = None;
        for k in 0..HALVINGS {
            let next = self.clamped(&(at + step * 0.5_f64.powi(k)));
            let there = self.jet_at(next.into());
            let cost = half_square(query, &there);
            let length = jet.moved(&(next - at)).norm();
            last = Some((next, there, cost, length));
            if cost < before || length < SURE_STEP * scale {
                break;
            }
        }
        last.filter(|(_, _, cost, _)| cost.is_finite())
    }

    fn clamped(&self, at: &Vector2<f64>) -> Vector2<f64> {
        let within = |d: usize| {
            let [from, to] = self.widened(d);
            at[d].clamp(from, to)
        };
        Vector2::new(within(0), within(1))
    }

    fn concluded(&self, query: &Point3<f64>, at: Vector2<f64>, jet: NurbsJet) -> Nearest {
        let arm = jet.point_mm - query;
        let metric = jet.metric();
        let hessian = metric + jet.bend_along(&arm);
        let beside = |metric: &Matrix2<f64>| {
            let gradient = Vector2::new(jet.tangents_mm[0].dot(&arm), jet.tangents_mm[1].dot(&arm));
            let inverse = metric.try_inverse().unwrap_or_else(Matrix2::zeros);
            gradient.dot(&(inverse * gradient)).max(0.0).sqrt()
        };
        let at: [f64; 2] = at.into();
        let (stiffness, beside_mm) = if self.has_collapsed(&metric) {
            // Where an edge has collapsed, its one direction is not the whole tangent plane.
            let d = usize::from(metric[(1, 1)] > metric[(0, 0)]);
            let normal = self.normal_of(&jet, at).map_or(Vector3::zeros(), Unit::into_inner);
            let beside_mm = (arm - normal * normal.dot(&arm)).norm();
            (hessian[(d, d)] / metric[(d, d)], beside_mm)
        } else {
            (least_ratio(&hessian, &metric), beside(&metric))
        };
        Nearest {
            at,
            point_mm: jet.point_mm,
            distance_mm: arm.norm(),
            beside_mm,
            stiffness,
            inside: self.is_inside(at),
        }
    }
}

impl Search<'_> {
    /// Distance beyond which nothing matters.
    fn within_mm(&self) -> f64 {
        let tie = TIE_SHARE * self.scale_mm;
        self.best.map_or(f64::INFINITY, |best| best.distance_mm + tie)
    }

    fn offer(&mut self, start: [f64; 2]) {
        let Some(found) = self.surface.descend(self.query_mm, start, self.scale_mm) else { return };
        // Where a seam or a pole stopped the way down, it goes on on the other side.
        if found.beside_mm > FOOT_SHARE * self.scale_mm && self.surface.goes_on(found.at) {
            return;
        }
        let Some(best) = self.best else {
            self.best = Some(found);
            return;
        };
        let apart_mm = (found.point_mm - best.point_mm).norm();
        // At a beside the foot the distance is √(d² + s a²), s the stiffness: round-off does not tell
        // nearer places apart.
        let tie_mm = TIE_SHARE * self.scale_mm;
        let square = tie_mm * (2.0 * best.distance_mm + tie_mm);
        let unresolved_mm = (square / best.stiffness.clamp(MIN_STIFFNESS, 1.0)).sqrt();
        let same_mm = unresolved_mm.max(SAME_SHARE * self.scale_mm);
        if apart_mm <= same_mm {
            // From both sides of a seam: that which is on the part; else the better foot.
            let better = found.beside_mm < best.beside_mm;
            if (found.inside && !best.inside) || (found.inside == best.inside && better) {
                self.best = Some(found);
            }
            return;
        }
        // A descent that round-off ended early is no rival of a foot that is as near.
        let [of_found, of_best] = [found, best].map(|n| n.beside_mm <= FOOT_SHARE * self.scale_mm);
        let handicap_mm = if of_found { 0.0 } else { tie_mm };
        let advantage_mm = if of_best { 0.0 } else { tie_mm };
        let (loser, loser_is_foot) =
            if found.distance_mm + handicap_mm < best.distance_mm + advantage_mm {
                self.best = Some(found);
                (best, of_best)
            } else {
                (found, of_found)
            };
        if loser_is_foot {
            self.rival_mm = self.rival_mm.min(loser.distance_mm);
        }
    }
}

/// Gradient and Hessian of half the squared distance.
struct Slope {
    gradient: Vector2<f64>,
    hessian: Matrix2<f64>,
    metric: Matrix2<f64>,
    /// Directions that an edge does not stop.
    free: [bool; 2],
}

impl Slope {
    fn new(surface: &Nurbs, query: &Point3<f64>, at: &Vector2<f64>, jet: &NurbsJet) -> Self {
        let arm = jet.point_mm - query;
        let gradient = Vector2::new(jet.tangents_mm[0].dot(&arm), jet.tangents_mm[1].dot(&arm));
        let metric = jet.metric();
        let free = [0, 1].map(|d| {
            let [from, to] = surface.widened(d);
            !(at[d] <= from && gradient[d] > 0.0 || at[d] >= to && gradient[d] < 0.0)
        });
        Self { gradient, hessian: metric + jet.bend_along(&arm), metric, free }
    }

    /// Newton's step where the Hessian allows it, else that of Gauss and Newton.
    fn step(&self) -> (Vector2<f64>, bool) {
        let (g, h) = (&self.gradient, &self.hessian);
        match self.free {
            [true, true] => {
                // Scaled, so that a tangent that all but vanishes does not hide the other.
                let scale = self.metric.diagonal().map(|m| m.max(f64::MIN_POSITIVE).sqrt().recip());
                let scaled =
                    |m: &Matrix2<f64>| Matrix2::from_fn(|i, j| scale[i] * m[(i, j)] * scale[j]);
                let right = -g.component_mul(&scale);
                if let Some(exact) = scaled(h).cholesky() {
                    return (exact.solve(&right).component_mul(&scale), true);
                }
                let metric = scaled(&self.metric) + Matrix2::identity() * f64::EPSILON;
                let flat = metric.cholesky().map_or(right, |m| m.solve(&right));
                (flat.component_mul(&scale), false)
            }
            [false, false] => (Vector2::zeros(), true),
            [free, _] => {
                let d = usize::from(!free);
                let exact = h[(d, d)] > 0.0;
                let stiffness = if exact { h[(d, d)] } else { self.metric[(d, d)] };
                let mut step = Vector2::zeros();
                step[d] = -g[d] / stiffness.max(f64::MIN_POSITIVE);
                (step, exact)
            }
        }
    }
}

/// The smaller eigenvalue of `metric⁻¹ hessian`.
fn least_ratio(hessian: &Matrix2<f64>, metric: &Matrix2<f64>) -> f64 {
    let Some(lower) = metric.cholesky().map(|c| c.l()) else { return 0.0 };
    let Some(inverse) = lower.try_inverse() else { return 0.0 };
    (inverse * hessian * inverse.transpose()).symmetric_eigenvalues().min()
}

fn half_square(query: &Point3<f64>, jet: &NurbsJet) -> f64 {
    0.5 * (jet.point_mm - query).norm_squared()
}
