use nalgebra::{Point3, Unit, Vector3};

use crate::{RegisterError, Side};

/// Coordinates beyond this are a wrong unit or a broken file, not a machine.
pub(crate) const MAX_COORDINATE_MM: f64 = 1e9;

/// Points are numbered in 32 bits, and the last number means «none».
const MAX_POINTS: usize = u32::MAX as usize - 1;

/// How far the length of a normal may be from 1; what single-precision files hold is 1e-7 off.
const UNIT_LENGTH_TOL: f64 = 1e-4;

/// Points of one object in one frame, with normals where they are known.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PointCloud {
    /// Positions.
    pub points_mm: Vec<Point3<f64>>,
    /// One unit normal per point.
    pub normals: Option<Vec<Unit<Vector3<f64>>>>,
}

impl PointCloud {
    /// Points without normals.
    #[must_use]
    pub fn new(points_mm: Vec<Point3<f64>>) -> Self {
        Self { points_mm, normals: None }
    }

    /// Points with their normals.
    #[must_use]
    pub fn with_normals(points_mm: Vec<Point3<f64>>, normals: Vec<Unit<Vector3<f64>>>) -> Self {
        Self { points_mm, normals: Some(normals) }
    }

    /// Checks that there are points, all finite, and one unit normal for each or none.
    ///
    /// # Errors
    ///
    /// [`RegisterError::Empty`], [`RegisterError::InvalidPoint`], [`RegisterError::NormalCount`],
    /// [`RegisterError::InvalidNormal`]; `side` is who they blame.
    pub fn check(&self, side: Side) -> Result<(), RegisterError> {
        if self.points_mm.is_empty() {
            return Err(RegisterError::Empty { side });
        }
        if self.points_mm.len() > MAX_POINTS {
            let (got, limit) = (self.points_mm.len(), MAX_POINTS);
            return Err(RegisterError::TooManyPoints { side, got, limit });
        }
        check_points(&self.points_mm, side)?;
        let Some(normals) = &self.normals else { return Ok(()) };
        if normals.len() != self.points_mm.len() {
            let (points, normals) = (self.points_mm.len(), normals.len());
            return Err(RegisterError::NormalCount { side, points, normals });
        }
        let is_unit = |n: &Unit<Vector3<f64>>| (n.norm() - 1.0).abs() <= UNIT_LENGTH_TOL;
        match normals.iter().position(|n| !is_unit(n)) {
            Some(index) => {
                Err(RegisterError::InvalidNormal { side, index, length: normals[index].norm() })
            }
            None => Ok(()),
        }
    }
}

pub(crate) fn check_points(points: &[Point3<f64>], side: Side) -> Result<(), RegisterError> {
    for (index, point) in points.iter().enumerate() {
        if let Some(&value) = point.iter().find(|v| v.is_nan() || v.abs() > MAX_COORDINATE_MM) {
            let limit = MAX_COORDINATE_MM;
            return Err(RegisterError::InvalidPoint { side, index, value, limit });
        }
    }
    Ok(())
}
