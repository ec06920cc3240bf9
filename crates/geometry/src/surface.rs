use std::fmt::Debug;

use nalgebra::{Matrix2, Point3, SymmetricEigen, Unit, Vector3};

use crate::{GeometryError, Line};

/// A smooth orientable surface, asked in its own frame.
///
/// The normal picks the side on which distances are positive.
pub trait Surface: Debug + Send + Sync {
    /// Point of the surface closest to a query point on either side.
    ///
    /// # Errors
    ///
    /// [`GeometryError::AmbiguousFoot`] where no single point is closest,
    /// [`GeometryError::OutsideAperture`] where the closest one is not on the part,
    /// [`GeometryError::NonFinite`].
    fn closest_point(&self, query_mm: &Point3<f64>) -> Result<Foot, GeometryError>;

    /// Principal curvatures at a point of the surface.
    ///
    /// A point beside the surface is taken along the surface's own projection: along the normal of
    /// a plane or sphere, along z for an asphere.
    ///
    /// # Errors
    ///
    /// [`GeometryError::SagUndefined`], [`GeometryError::NonFinite`].
    fn curvature(&self, point_mm: &Point3<f64>) -> Result<Curvature, GeometryError>;

    /// Whether it is made of flat faces, whose curvature says nothing of the surface that they stand for.
    ///
    /// [`Surface::curvature`] is then zero wherever it is asked for.
    fn is_faceted(&self) -> bool {
        false
    }

    /// All points in which a line, endless both ways, meets the surface, in the line's direction.
    ///
    /// # Errors
    ///
    /// Never an empty list: [`GeometryError::Misses`], [`GeometryError::OutsideAperture`],
    /// [`GeometryError::SagUndefined`] or [`GeometryError::LineInSurface`] say why there is none.
    fn hits(&self, line: &Line) -> Result<Vec<Hit>, GeometryError>;

    /// First point at or ahead of the ray's start in which the ray meets the surface.
    ///
    /// Does not allocate, but for a [`FormedSurface`](crate::FormedSurface).
    ///
    /// # Errors
    ///
    /// As [`Surface::hits`], and [`GeometryError::BehindRay`].
    fn first_hit(&self, ray: &Line) -> Result<Hit, GeometryError>;
}

/// Foot of the perpendicular from a query point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Foot {
    /// The closest point of the surface.
    pub point_mm: Point3<f64>,
    /// Unit normal of the surface there.
    pub normal: Unit<Vector3<f64>>,
    /// Distance of the query from the surface, positive on the normal's side.
    pub signed_distance_mm: f64,
    /// Whether the foot is within the aperture; `true` for a surface without one.
    pub inside_aperture: bool,
}

/// Principal curvatures; positive where the surface curves towards its normal (a bowl).
///
/// A ball of radius r on the normal's side touches without cutting in where
/// `r · major_per_mm < 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Curvature {
    /// The algebraically larger principal curvature.
    pub major_per_mm: f64,
    /// The algebraically smaller principal curvature.
    pub minor_per_mm: f64,
    /// Tangent along which the surface has `major_per_mm`; any tangent where both are equal.
    pub major_direction: Unit<Vector3<f64>>,
    /// Tangent along which the surface has `minor_per_mm`; normal × `major_direction`, or opposite.
    pub minor_direction: Unit<Vector3<f64>>,
}

impl Curvature {
    /// Mean of the principal curvatures.
    #[must_use]
    pub fn mean_per_mm(&self) -> f64 {
        0.5 * (self.major_per_mm + self.minor_per_mm)
    }

    /// Product of the principal curvatures.
    #[must_use]
    pub fn gaussian_per_mm2(&self) -> f64 {
        self.major_per_mm * self.minor_per_mm
    }

    /// That of a second fundamental form over two orthonormal tangents.
    pub(crate) fn of_shape(
        shape: &Matrix2<f64>,
        first: &Vector3<f64>,
        second: &Vector3<f64>,
    ) -> Self {
        let eigen = SymmetricEigen::new(*shape);
        let major = usize::from(eigen.eigenvalues[1] > eigen.eigenvalues[0]);
        let direction = |k: usize| {
            let v = eigen.eigenvectors.column(k);
            Unit::new_normalize(first * v[0] + second * v[1])
        };
        Self {
            major_per_mm: eigen.eigenvalues[major],
            minor_per_mm: eigen.eigenvalues[1 - major],
            major_direction: direction(major),
            minor_direction: direction(1 - major),
        }
    }

    pub(crate) fn umbilic(per_mm: f64, normal: &Unit<Vector3<f64>>) -> Self {
        // The axis least aligned with the normal gives the best conditioned tangent.
        let axis = normal.iamin();
        let tangent = Unit::new_normalize(normal.cross(&Vector3::ith(axis, 1.0)));
        Self {
            major_per_mm: per_mm,
            minor_per_mm: per_mm,
            major_direction: tangent,
            minor_direction: Unit::new_unchecked(normal.cross(&tangent)),
        }
    }
}

/// The first hit ahead of a ray's start, or why there is none: the last one behind it, in mm along
/// the ray, or nothing at all.
pub(crate) fn ahead(first: Option<Hit>, behind_mm: Option<f64>) -> Result<Hit, GeometryError> {
    match (first, behind_mm) {
        (Some(hit), _) => Ok(hit),
        (None, Some(distance)) => Err(GeometryError::BehindRay { distance_mm: -distance }),
        (None, None) => Err(GeometryError::Misses),
    }
}

/// A point in which a line meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Hit {
    /// Distance along the line from its point; negative behind it.
    pub distance_mm: f64,
    /// The common point.
    pub point_mm: Point3<f64>,
    /// Unit normal of the surface there.
    pub normal: Unit<Vector3<f64>>,
}
