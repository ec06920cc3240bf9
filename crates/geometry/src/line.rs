use nalgebra::{Point3, Unit, Vector3};

use crate::GeometryError;
use crate::error::finite;

/// Directed straight line through a point; a ray where only what lies ahead counts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Line {
    /// A point of the line; the start of the ray.
    pub point_mm: Point3<f64>,
    /// Direction in which the distance along the line grows.
    pub direction: Unit<Vector3<f64>>,
}

impl Line {
    /// Line through a point along a direction of any length.
    ///
    /// # Errors
    ///
    /// [`GeometryError::NoDirection`] for a zero vector, [`GeometryError::NonFinite`].
    pub fn new(point_mm: Point3<f64>, direction: Vector3<f64>) -> Result<Self, GeometryError> {
        finite(point_mm.iter(), "point of the line")?;
        let direction = unit(direction, "direction of the line")?;
        Ok(Self { point_mm, direction })
    }

    /// Point at a signed distance along the direction.
    #[must_use]
    pub fn at(&self, distance_mm: f64) -> Point3<f64> {
        self.point_mm + self.direction.into_inner() * distance_mm
    }

    /// The same line, directed the other way.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self { point_mm: self.point_mm, direction: -self.direction }
    }
}

/// Normalises a vector of any finite length.
pub(crate) fn unit(
    vector: Vector3<f64>,
    argument: &'static str,
) -> Result<Unit<Vector3<f64>>, GeometryError> {
    finite(vector.iter(), argument)?;
    // Divided by its largest entry first: squares of very long or short vectors leave f64.
    let largest = vector.amax();
    if largest == 0.0 {
        return Err(GeometryError::NoDirection { argument });
    }
    Ok(Unit::new_normalize(vector / largest))
}
