use nalgebra::{Point3, Unit, Vector3};

use crate::error::finite;
use crate::line::unit;
use crate::{Curvature, Foot, GeometryError, Hit, Line, Surface};

/// Below this `|normal · direction|`, the round-off of two unit vectors, a line is parallel.
const PARALLEL: f64 = 4.0 * f64::EPSILON;

/// Unbounded plane; distances are positive on the side its normal points to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    point_mm: Point3<f64>,
    normal: Unit<Vector3<f64>>,
}

impl Plane {
    /// Plane through a point, normal to a vector of any length.
    ///
    /// # Errors
    ///
    /// [`GeometryError::NoDirection`] for a zero normal, [`GeometryError::NonFinite`].
    pub fn new(point_mm: Point3<f64>, normal: Vector3<f64>) -> Result<Self, GeometryError> {
        finite(point_mm.iter(), "point of the plane")?;
        Ok(Self { point_mm, normal: unit(normal, "normal of the plane")? })
    }

    /// The point the plane was made with.
    #[must_use]
    pub fn point_mm(&self) -> Point3<f64> {
        self.point_mm
    }

    /// Unit normal.
    #[must_use]
    pub fn normal(&self) -> Unit<Vector3<f64>> {
        self.normal
    }

    /// Distance of a point from the plane, positive on the normal's side.
    #[must_use]
    pub fn signed_distance_mm(&self, point_mm: &Point3<f64>) -> f64 {
        self.normal.dot(&(point_mm - self.point_mm))
    }

    fn hit(&self, line: &Line) -> Result<Hit, GeometryError> {
        let height = self.signed_distance_mm(&line.point_mm);
        finite([&height], "point of the line")?;
        let approach = self.normal.dot(&line.direction);
        if approach.abs() <= PARALLEL {
            let size = line.point_mm.coords.amax() + self.point_mm.coords.amax();
            let inside = height.abs() <= 8.0 * f64::EPSILON * size;
            return Err(if inside { GeometryError::LineInSurface } else { GeometryError::Misses });
        }
        let distance_mm = -height / approach;
        finite([&distance_mm], "direction of the line")?;
        Ok(Hit { distance_mm, point_mm: line.at(distance_mm), normal: self.normal })
    }
}

impl Surface for Plane {
    fn closest_point(&self, query_mm: &Point3<f64>) -> Result<Foot, GeometryError> {
        let signed_distance_mm = self.signed_distance_mm(query_mm);
        finite([&signed_distance_mm], "query point")?;
        let point_mm = query_mm - self.normal.into_inner() * signed_distance_mm;
        Ok(Foot { point_mm, normal: self.normal, signed_distance_mm, inside_aperture: true })
    }

    fn curvature(&self, point_mm: &Point3<f64>) -> Result<Curvature, GeometryError> {
        finite(point_mm.iter(), "point on the surface")?;
        Ok(Curvature::umbilic(0.0, &self.normal))
    }

    fn hits(&self, line: &Line) -> Result<Vec<Hit>, GeometryError> {
        Ok(vec![self.hit(line)?])
    }

    fn first_hit(&self, ray: &Line) -> Result<Hit, GeometryError> {
        let hit = self.hit(ray)?;
        if hit.distance_mm < 0.0 {
            return Err(GeometryError::BehindRay { distance_mm: -hit.distance_mm });
        }
        Ok(hit)
    }
}
