use nalgebra::{Matrix2, Point3, Vector2, Vector3};

use super::{Jet, Polynomial, upward};
use crate::{Foot, GeometryError};

/// Steps before the query is taken for one near a centre of curvature.
const MAX_STEPS: usize = 100;
/// Steps below this share of the lengths in the problem leave, squared, no error.
const LAST_STEP: f64 = 1e-9;
/// Steps below this share converge by themselves.
const SURE_STEP: f64 = 1e-4;
/// A foot is refused where the round-off of the query is magnified more than a million times.
const MIN_STIFFNESS: f64 = 1e-6;

impl Polynomial {
    /// Newton's method on half the squared distance, from the query's own projection.
    pub(super) fn foot(&self, query: &Point3<f64>) -> Result<Foot, GeometryError> {
        let mut at = query.xy().coords;
        let mut jet = self.jet(at.x, at.y);
        let mut cost = half_square(query, &at, &jet);
        for _ in 0..MAX_STEPS {
            let (gradient, hessian, metric) = derivatives(query, &at, &jet);
            let exact = hessian.cholesky().map(|h| -h.solve(&gradient));
            let step = exact.unwrap_or_else(|| -solve(&metric, &gradient));
            let length = step.amax() / (1.0 + query.coords.amax());
            if exact.is_some() && length < LAST_STEP {
                return self.conclude(query, &(at + step), &hessian, &metric);
            }
            if exact.is_some() && length < SURE_STEP {
                // Rounding of the distance itself hides what so short a step gains.
                at += step;
                jet = self.jet(at.x, at.y);
                cost = half_square(query, &at, &jet);
                continue;
            }
            let Some(next) = self.descend(query, &at, &step, cost) else {
                // No step is closer: there is no minimum here.
                return self.conclude(query, &at, &hessian, &metric);
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
        &self,
        query: &Point3<f64>,
        at: &Vector2<f64>,
        step: &Vector2<f64>,
        before: f64,
    ) -> Option<(Vector2<f64>, Jet, f64)> {
        const HALVINGS: i32 = 40;
        (0..HALVINGS).find_map(|k| {
            let next = at + step * 0.5_f64.powi(k);
            let jet = self.jet(next.x, next.y);
            let cost = half_square(query, &next, &jet);
            (cost < before).then_some((next, jet, cost))
        })
    }

    fn conclude(
        &self,
        query: &Point3<f64>,
        at: &Vector2<f64>,
        hessian: &Matrix2<f64>,
        metric: &Matrix2<f64>,
    ) -> Result<Foot, GeometryError> {
        let jet = self.jet(at.x, at.y);
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
        Ok(Foot { point_mm, normal, signed_distance_mm, inside_aperture: true })
    }
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
