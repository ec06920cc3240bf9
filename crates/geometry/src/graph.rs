//! Surfaces that are a height over the xy plane.

use std::ops::ControlFlow;

use nalgebra::{Matrix2, Point3, Unit, Vector2, Vector3};

use crate::error::finite;
use crate::surface::ahead;
use crate::{Curvature, Foot, GeometryError, Hit, Line};

/// A smooth height over the xy plane.
pub(crate) trait Graph {
    /// Height with its derivatives; smooth beyond the part too.
    fn jet(&self, x: f64, y: f64) -> Jet;

    /// Whether there is a part above that place.
    fn contains(&self, x: f64, y: f64) -> bool;

    /// Visits the meetings with a line, in its direction.
    fn each_hit(
        &self,
        line: &Line,
        visit: &mut impl FnMut(Hit) -> ControlFlow<()>,
    ) -> Result<(), GeometryError>;
}

/// All meetings with a line.
pub(crate) fn hits(graph: &impl Graph, line: &Line) -> Result<Vec<Hit>, GeometryError> {
    let mut hits = Vec::new();
    graph.each_hit(line, &mut |hit| {
        hits.push(hit);
        ControlFlow::Continue(())
    })?;
    Ok(hits)
}

/// The first meeting ahead of a ray's start.
pub(crate) fn first_hit(graph: &impl Graph, ray: &Line) -> Result<Hit, GeometryError> {
    let (mut first, mut behind) = (None, None);
    graph.each_hit(ray, &mut |hit| {
        if hit.distance_mm >= 0.0 {
            first = Some(hit);
            return ControlFlow::Break(());
        }
        behind = Some(hit.distance_mm);
        ControlFlow::Continue(())
    })?;
    ahead(first, behind)
}

/// The meeting at a distance along a line.
pub(crate) fn hit(graph: &impl Graph, line: &Line, distance_mm: f64) -> Hit {
    let point_mm = line.at(distance_mm);
    let gradient = graph.jet(point_mm.x, point_mm.y).gradient;
    Hit { distance_mm, point_mm, normal: upward(&gradient) }
}

/// Height with its derivatives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jet {
    pub(crate) z: f64,
    pub(crate) gradient: Vector2<f64>,
    pub(crate) hessian: Matrix2<f64>,
}

/// Steps before the query is taken for one near a centre of curvature.
const MAX_STEPS: usize = 100;
/// Steps below this share of the lengths in the problem leave, squared, no error.
const LAST_STEP: f64 = 1e-9;
/// Steps below this share converge by themselves.
const SURE_STEP: f64 = 1e-4;
/// A foot is refused where the round-off of the query is magnified more than a million times.
const MIN_STIFFNESS: f64 = 1e-6;

/// Newton's method on half the squared distance, from the query's own projection.
pub(crate) fn foot(graph: &impl Graph, query: &Point3<f64>) -> Result<Foot, GeometryError> {
    let mut at = query.xy().coords;
    let mut jet = graph.jet(at.x, at.y);
    let mut cost = half_square(query, &at, &jet);
    for _ in 0..MAX_STEPS {
        let (gradient, hessian, metric) = derivatives(query, &at, &jet);
        let exact = hessian.cholesky().map(|h| -h.solve(&gradient));
        let step = exact.unwrap_or_else(|| -solve(&metric, &gradient));
        let length = step.amax() / (1.0 + query.coords.amax());
        if exact.is_some() && length < LAST_STEP {
            return conclude(graph, query, &(at + step), &hessian, &metric);
        }
        if exact.is_some() && length < SURE_STEP {
            // Rounding of the distance itself hides what so short a step gains.
            at += step;
            jet = graph.jet(at.x, at.y);
            cost = half_square(query, &at, &jet);
            continue;
        }
        let Some(next) = descend(graph, query, &at, &step, cost) else {
            // No step is closer: there is no minimum here.
            return conclude(graph, query, &at, &hessian, &metric);
        };
        (at, jet, cost) = next;
        if !cost.is_finite() {
            break;
        }
    }
    Err(GeometryError::AmbiguousFoot { distance_mm: (2.0 * cost).sqrt() })
}

/// The first of the step, its half, … that is closer.
fn descend(
    graph: &impl Graph,
    query: &Point3<f64>,
    at: &Vector2<f64>,
    step: &Vector2<f64>,
    before: f64,
) -> Option<(Vector2<f64>, Jet, f64)> {
    const HALVINGS: i32 = 40;
    (0..HALVINGS).find_map(|k| {
        let next = at + step * 0.5_f64.powi(k);
        let jet = graph.jet(next.x, next.y);
        let cost = half_square(query, &next, &jet);
        (cost < before).then_some((next, jet, cost))
    })
}

fn conclude(
    graph: &impl Graph,
    query: &Point3<f64>,
    at: &Vector2<f64>,
    hessian: &Matrix2<f64>,
    metric: &Matrix2<f64>,
) -> Result<Foot, GeometryError> {
    let jet = graph.jet(at.x, at.y);
    let point_mm = Point3::new(at.x, at.y, jet.z);
    let normal = upward(&jet.gradient);
    let signed_distance_mm = normal.dot(&(query - point_mm));
    // Both stiffnesses `1 − κ d` are positive where the Hessian is, relative to the metric.
    let determinant = hessian.determinant() / metric.determinant();
    let trace = solve(metric, &hessian.column(0).into_owned()).x
        + solve(metric, &hessian.column(1).into_owned()).y;
    if determinant < MIN_STIFFNESS * MIN_STIFFNESS || trace < MIN_STIFFNESS {
        return Err(GeometryError::AmbiguousFoot { distance_mm: signed_distance_mm.abs() });
    }
    let inside_aperture = graph.contains(at.x, at.y);
    Ok(Foot { point_mm, normal, signed_distance_mm, inside_aperture })
}
fn half_square(query: &Point3<f64>, at: &Vector2<f64>, jet: &Jet) -> f64 {
    0.5 * Vector3::new(at.x - query.x, at.y - query.y, jet.z - query.z).norm_squared()
}

/// Gradient and Hessian of half the squared distance, and the Hessian without the surface's bend.
fn derivatives(
    query: &Point3<f64>,
    at: &Vector2<f64>,
    jet: &Jet,
) -> (Vector2<f64>, Matrix2<f64>, Matrix2<f64>) {
    let gap = jet.z - query.z;
    let gradient = at - query.xy().coords + jet.gradient * gap;
    let metric = Matrix2::identity() + jet.gradient * jet.gradient.transpose();
    (gradient, metric + jet.hessian * gap, metric)
}

/// `A⁻¹ b` of a matrix that is at least the identity.
fn solve(a: &Matrix2<f64>, b: &Vector2<f64>) -> Vector2<f64> {
    let adjugate = Matrix2::new(a[(1, 1)], -a[(0, 1)], -a[(1, 0)], a[(0, 0)]);
    adjugate * b / a.determinant()
}

/// Principal curvatures above the place of a point.
pub(crate) fn curvature(
    graph: &impl Graph,
    point_mm: &Point3<f64>,
) -> Result<Curvature, GeometryError> {
    let Jet { gradient, hessian, .. } = graph.jet(point_mm.x, point_mm.y);
    finite(hessian.iter(), "position on the surface")?;
    let normal = upward(&gradient);
    // Tangents that are orthonormal in space, by their x and y.
    let first = Vector3::new(1.0, 0.0, gradient.x).normalize();
    let second = normal.cross(&first);
    let stretch = (1.0 + gradient.norm_squared()).sqrt();
    let form = |a: &Vector3<f64>, b: &Vector3<f64>| a.xy().dot(&(hessian * b.xy())) / stretch;
    let mixed = form(&first, &second);
    let shape = Matrix2::new(form(&first, &first), mixed, mixed, form(&second, &second));
    Ok(Curvature::of_shape(&shape, &first, &second))
}

pub(crate) fn upward(gradient: &Vector2<f64>) -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::new(-gradient.x, -gradient.y, 1.0))
}
