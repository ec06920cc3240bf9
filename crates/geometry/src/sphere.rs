use nalgebra::{Point3, Unit, Vector3};

use crate::error::finite;
use crate::{Curvature, Foot, GeometryError, Hit, Line, Surface};

/// Queries closer to the centre than this share of the radius have no usable foot.
///
/// The foot's direction then carries the query's round-off magnified by its inverse, as in
/// the asphere's limit.
const MIN_CENTER_RATIO: f64 = 1e-6;

/// Whole sphere; its normal points outwards, so both curvatures are −1/radius.
///
/// For the inside of a bore or a concave seat, the caller flips the sign of distance and curvature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    center_mm: Point3<f64>,
    radius_mm: f64,
}

impl Sphere {
    /// Sphere of a positive radius.
    ///
    /// # Errors
    ///
    /// [`GeometryError::InvalidRadius`] unless positive, [`GeometryError::NonFinite`].
    pub fn new(center_mm: Point3<f64>, radius_mm: f64) -> Result<Self, GeometryError> {
        finite(center_mm.iter(), "centre of the sphere")?;
        finite([&radius_mm], "radius of the sphere")?;
        if radius_mm <= 0.0 {
            return Err(GeometryError::InvalidRadius { radius_mm });
        }
        Ok(Self { center_mm, radius_mm })
    }

    /// Centre.
    #[must_use]
    pub fn center_mm(&self) -> Point3<f64> {
        self.center_mm
    }

    /// Radius.
    #[must_use]
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// Direction and distance of a point from the centre.
    fn radial(&self, point_mm: &Point3<f64>) -> Result<(Unit<Vector3<f64>>, f64), GeometryError> {
        let arm = point_mm - self.center_mm;
        let length = arm.norm();
        finite([&length], "query point")?;
        if length <= MIN_CENTER_RATIO * self.radius_mm {
            return Err(GeometryError::AmbiguousFoot { distance_mm: self.radius_mm - length });
        }
        Ok((Unit::new_unchecked(arm / length), length))
    }

    fn hit(&self, line: &Line, distance_mm: f64) -> Hit {
        let point_mm = line.at(distance_mm);
        let normal = Unit::new_normalize(point_mm - self.center_mm);
        Hit { distance_mm, point_mm, normal }
    }

    /// Distances along the line of entry and exit; equal for a tangent.
    fn chord(&self, line: &Line) -> Result<[f64; 2], GeometryError> {
        let arm = line.point_mm - self.center_mm;
        let along = arm.dot(&line.direction);
        let across = (arm - line.direction.into_inner() * along).norm();
        finite([&across, &along], "point of the line")?;
        // (R − a)(R + a): no cancellation of squares near the rim.
        let square = (self.radius_mm - across) * (self.radius_mm + across);
        if square < 0.0 {
            return Err(GeometryError::Misses);
        }
        let half = square.sqrt();
        Ok([-along - half, -along + half])
    }
}

impl Surface for Sphere {
    fn closest_point(&self, query_mm: &Point3<f64>) -> Result<Foot, GeometryError> {
        let (normal, length) = self.radial(query_mm)?;
        Ok(Foot {
            point_mm: self.center_mm + normal.into_inner() * self.radius_mm,
            normal,
            signed_distance_mm: length - self.radius_mm,
            inside_aperture: true,
        })
    }

    fn curvature(&self, point_mm: &Point3<f64>) -> Result<Curvature, GeometryError> {
        let (normal, _) = self.radial(point_mm)?;
        Ok(Curvature::umbilic(-1.0 / self.radius_mm, &normal))
    }

    fn hits(&self, line: &Line) -> Result<Vec<Hit>, GeometryError> {
        let [entry, exit] = self.chord(line)?;
        let mut hits = vec![self.hit(line, entry)];
        if exit > entry {
            hits.push(self.hit(line, exit));
        }
        Ok(hits)
    }

    fn first_hit(&self, ray: &Line) -> Result<Hit, GeometryError> {
        let [entry, exit] = self.chord(ray)?;
        if exit < 0.0 {
            return Err(GeometryError::BehindRay { distance_mm: -exit });
        }
        Ok(self.hit(ray, if entry >= 0.0 { entry } else { exit }))
    }
}
