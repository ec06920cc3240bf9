use std::sync::Arc;

use nalgebra::{Matrix2, Point3, Unit, Vector2, Vector3};

use crate::error::finite;
use crate::graph::Jet;
use crate::surface::ahead;
use crate::{Curvature, Foot, GeometryError, HeightGrid, Hit, Line, Surface};

/// Steps before the query is taken for one near a centre of curvature.
const MAX_STEPS: usize = 50;
/// Steps below this share of the lengths in the problem leave, squared, no error.
const LAST_STEP: f64 = 1e-9;
/// A foot is refused where the round-off of the query is magnified more than a million times.
const MIN_STIFFNESS: f64 = 1e-6;
/// Distances along a line below this share of the lengths in the problem are round-off.
const LAST_DISTANCE: f64 = 1e-13;

/// Along what a map of deviations moves a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum DeviationAlong {
    /// The surface's own normal.
    #[default]
    Normal,
    /// The z axis.
    Z,
}

/// A nominal surface with a measured map of its deviations: S(P) = P + w(x, y) u.
///
/// P is a point of the nominal surface at x, y, and u its normal there or the z axis. The distance
/// and the normal are those of the sum, exact to round-off, with the slopes of the map and the
/// curvature of the nominal surface in them. Curvatures along z are as exact; along the normal they
/// leave out w ∇κ·∇w, of second order in the map: 1e-11 /mm for 1 µm and 0.1 mrad on an asphere.
///
/// A foot is within the aperture where it is within that of the nominal surface and the map was
/// measured there; beside the map, the deviation goes on along its slope at the border. A nominal surface
/// without a smooth normal (a mesh) makes none: move its corners instead.
#[derive(Clone, Debug)]
pub struct FormedSurface {
    nominal: Arc<dyn Surface>,
    map_mm: HeightGrid,
    along: DeviationAlong,
}

/// The sum around one point of the nominal surface, to the second order of steps along the nominal
/// surface's principal directions.
#[derive(Clone, Copy, Debug)]
struct Around {
    point_mm: Point3<f64>,
    /// Principal directions of the nominal surface.
    steps: [Unit<Vector3<f64>>; 2],
    /// Derivatives by steps along them.
    tangents: [Vector3<f64>; 2],
    /// Second derivatives by them: along the first, both, the second.
    bends: [Vector3<f64>; 3],
    normal: Unit<Vector3<f64>>,
}

impl FormedSurface {
    /// The sum of a nominal surface and the deviations in mm over its x and y.
    #[must_use]
    pub fn new(nominal: Arc<dyn Surface>, map_mm: HeightGrid, along: DeviationAlong) -> Self {
        Self { nominal, map_mm, along }
    }

    /// The sum at a foot on the nominal surface.
    fn around(&self, on: &Foot) -> Result<Around, GeometryError> {
        let bent = self.nominal.curvature(&on.point_mm)?;
        let steps = [bent.major_direction, bent.minor_direction];
        let kappa = [bent.major_per_mm, bent.minor_per_mm];
        let n = on.normal.into_inner();
        let Jet { z: w, gradient, hessian } = self.map_mm.continued(on.point_mm.x, on.point_mm.y);
        let slope = steps.map(|t| gradient.dot(&t.xy()));
        let h = |i: usize, j: usize| if i == j { kappa[i] } else { 0.0 };
        // The map's second derivative along the nominal surface, which bends away from its tangents.
        let twice = |i: usize, j: usize| {
            steps[i].xy().dot(&(hessian * steps[j].xy())) + h(i, j) * gradient.dot(&n.xy())
        };
        let pairs = [(0, 0), (0, 1), (1, 1)];
        // The normal turns by −κ t along a principal direction t.
        let (tangents, bends) = match self.along {
            DeviationAlong::Normal => (
                [0, 1].map(|i| steps[i].into_inner() * (1.0 - w * kappa[i]) + n * slope[i]),
                pairs.map(|(i, j)| {
                    n * (h(i, j) + twice(i, j) - w * h(i, j) * kappa[i])
                        - steps[j].into_inner() * (slope[i] * kappa[j])
                        - steps[i].into_inner() * (slope[j] * kappa[i])
                }),
            ),
            DeviationAlong::Z => (
                [0, 1].map(|i| steps[i].into_inner() + Vector3::z() * slope[i]),
                pairs.map(|(i, j)| n * h(i, j) + Vector3::z() * twice(i, j)),
            ),
        };
        let up = match self.along {
            DeviationAlong::Normal => n,
            DeviationAlong::Z => Vector3::z(),
        };
        let across = tangents[0].cross(&tangents[1]);
        let normal = Unit::new_normalize(across * across.dot(&n).signum());
        finite(normal.iter(), "deviation of the surface")?;
        Ok(Around { point_mm: on.point_mm + up * w, steps, tangents, bends, normal })
    }

    /// The closest point with the sum around it.
    fn foot(&self, query: &Point3<f64>) -> Result<(Foot, Around), GeometryError> {
        finite([&query.coords.norm_squared()], "query point")?;
        let mut on = self.nominal.closest_point(query)?;
        let scale = 1.0 + query.coords.amax();
        let mut is_last = false;
        for _ in 0..MAX_STEPS {
            let around = self.around(&on)?;
            let away = query - around.point_mm;
            let metric = around.metric();
            let hessian = metric - around.bend_along(&away);
            let pull = Vector2::from_fn(|i, _| away.dot(&around.tangents[i]));
            if is_last {
                return Ok((self.conclude(query, &on, &around, &hessian, &metric)?, around));
            }
            // Away from a minimum: downhill by the metric alone.
            let step = hessian.cholesky().or_else(|| metric.cholesky()).map(|h| h.solve(&pull));
            let Some(step) = step.filter(|step| step.iter().all(|s| s.is_finite())) else { break };
            is_last = step.amax() < LAST_STEP * scale;
            let stepped =
                around.steps[0].into_inner() * step.x + around.steps[1].into_inner() * step.y;
            on = self.nominal.closest_point(&(on.point_mm + stepped))?;
        }
        let distance_mm = (query - on.point_mm).norm();
        Err(GeometryError::AmbiguousFoot { distance_mm })
    }

    fn conclude(
        &self,
        query: &Point3<f64>,
        on: &Foot,
        around: &Around,
        hessian: &Matrix2<f64>,
        metric: &Matrix2<f64>,
    ) -> Result<Foot, GeometryError> {
        let signed_distance_mm = around.normal.dot(&(query - around.point_mm));
        // Both stiffnesses `1 − κ d` are positive where the Hessian is, relative to the metric.
        let relative = metric.try_inverse().map(|inverse| inverse * hessian);
        let is_stiff = |m: Matrix2<f64>| {
            m.determinant() >= MIN_STIFFNESS * MIN_STIFFNESS && m.trace() >= MIN_STIFFNESS
        };
        if !relative.is_some_and(is_stiff) {
            return Err(GeometryError::AmbiguousFoot { distance_mm: signed_distance_mm.abs() });
        }
        Ok(Foot {
            point_mm: around.point_mm,
            normal: around.normal,
            signed_distance_mm,
            inside_aperture: on.inside_aperture
                && self.map_mm.is_measured(on.point_mm.x, on.point_mm.y),
        })
    }

    /// Where the line meets the sum, looked for from a distance along it.
    fn meeting(&self, line: &Line, from_mm: f64) -> Option<Hit> {
        let mut distance_mm = from_mm;
        let mut before = f64::INFINITY;
        for _ in 0..MAX_STEPS {
            let point_mm = line.at(distance_mm);
            let (foot, _) = self.foot(&point_mm).ok()?;
            let step = foot.signed_distance_mm / foot.normal.dot(&line.direction);
            if !step.is_finite() {
                return None;
            }
            let round_off = LAST_DISTANCE * (1.0 + point_mm.coords.amax() + distance_mm.abs());
            distance_mm -= step;
            if step.abs() <= round_off || (step.abs() >= before && before <= LAST_STEP) {
                let point_mm = line.at(distance_mm);
                return foot.inside_aperture.then_some(Hit {
                    distance_mm,
                    point_mm,
                    normal: foot.normal,
                });
            }
            before = step.abs();
        }
        None
    }
}

impl Around {
    /// Products of the tangents.
    fn metric(&self) -> Matrix2<f64> {
        Matrix2::from_fn(|i, j| self.tangents[i].dot(&self.tangents[j]))
    }

    /// Second derivatives along a direction.
    fn bend_along(&self, direction: &Vector3<f64>) -> Matrix2<f64> {
        Matrix2::from_fn(|i, j| self.bends[i + j].dot(direction))
    }
}

impl Surface for FormedSurface {
    fn closest_point(&self, query_mm: &Point3<f64>) -> Result<Foot, GeometryError> {
        Ok(self.foot(query_mm)?.0)
    }

    fn curvature(&self, point_mm: &Point3<f64>) -> Result<Curvature, GeometryError> {
        let (_, around) = self.foot(point_mm)?;
        let first = around.tangents[0].normalize();
        let second = around.normal.cross(&first);
        let inverse = around.metric().try_inverse();
        let inverse =
            inverse.ok_or(GeometryError::NonFinite { argument: "position on the surface" })?;
        // Steps that make a unit along each tangent.
        let step =
            |along: &Vector3<f64>| inverse * Vector2::from_fn(|i, _| around.tangents[i].dot(along));
        let steps = [step(&first), step(&second)];
        let bend = around.bend_along(&around.normal);
        let shape = Matrix2::from_fn(|i, j| steps[i].dot(&(bend * steps[j])));
        finite(shape.iter(), "position on the surface")?;
        Ok(Curvature::of_shape(&shape, &first, &second))
    }

    /// Found from where the line meets the nominal surface: one that only grazes the sum may be missed.
    fn hits(&self, line: &Line) -> Result<Vec<Hit>, GeometryError> {
        let of_nominal = self.nominal.hits(line)?;
        let mut hits: Vec<Hit> =
            of_nominal.iter().filter_map(|hit| self.meeting(line, hit.distance_mm)).collect();
        hits.sort_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm));
        hits.dedup_by(|a, b| (a.distance_mm - b.distance_mm).abs() <= LAST_STEP);
        if hits.is_empty() { Err(GeometryError::Misses) } else { Ok(hits) }
    }

    /// As [`FormedSurface::hits`], and it allocates.
    fn first_hit(&self, ray: &Line) -> Result<Hit, GeometryError> {
        let hits = self.hits(ray)?;
        let first = hits.iter().find(|hit| hit.distance_mm >= 0.0).copied();
        ahead(first, hits.last().map(|hit| hit.distance_mm))
    }
}
