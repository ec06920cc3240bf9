use std::ops::Mul;

use nalgebra::{
    Isometry2, Matrix2, Matrix3, Point2, Rotation2, Translation2, UnitComplex, Vector2,
};

use crate::GeometryError;
use crate::error::finite;

/// Affine map of the plane: `target = linear · source + translation`.
///
/// Holds what [`Isometry2`] cannot: reflection (a sensor whose z opposes the machine's), scale
/// and shear.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PlanarMap {
    /// Ratio of target to source coordinates.
    pub linear: Matrix2<f64>,
    /// Image of the source origin.
    pub translation_mm: Vector2<f64>,
}

/// What a planar map does: `linear = Rot(angle) · Mirror · stretch` (polar decomposition).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PlanarParts {
    /// Angle of the rotation, −π to π.
    pub angle_rad: f64,
    /// Whether `Mirror` is diag(1, −1), else it is the identity.
    pub reflected: bool,
    /// Symmetric, positive semi-definite; the identity for a rigid map.
    pub stretch: Matrix2<f64>,
    /// Larger singular value of `linear`, an eigenvalue of `stretch`.
    pub major_scale: f64,
    /// Smaller singular value of `linear`, an eigenvalue of `stretch`.
    pub minor_scale: f64,
}

impl PlanarMap {
    /// The map that changes nothing.
    #[must_use]
    pub fn identity() -> Self {
        Self { linear: Matrix2::identity(), translation_mm: Vector2::zeros() }
    }

    /// Rotation, preceded by the mirror y → −y if `reflected`, followed by a translation.
    #[must_use]
    pub fn rigid(angle_rad: f64, reflected: bool, translation_mm: Vector2<f64>) -> Self {
        let mirror = if reflected { -1.0 } else { 1.0 };
        let linear =
            Rotation2::new(angle_rad).into_inner() * Matrix2::from_diagonal(&[1.0, mirror].into());
        Self { linear, translation_mm }
    }

    /// Image of a point.
    #[must_use]
    pub fn apply(&self, point_mm: &Point2<f64>) -> Point2<f64> {
        Point2::from(self.linear * point_mm.coords + self.translation_mm)
    }

    /// As a homogeneous `3 × 3` matrix with last row `0 0 1`.
    #[must_use]
    pub fn to_homogeneous(&self) -> Matrix3<f64> {
        let mut out = Matrix3::identity();
        out.fixed_view_mut::<2, 2>(0, 0).copy_from(&self.linear);
        out.fixed_view_mut::<2, 1>(0, 2).copy_from(&self.translation_mm);
        out
    }

    /// Angle, reflection and stretch.
    ///
    /// For a determinant of zero the map is taken as not reflected.
    #[must_use]
    pub fn parts(&self) -> PlanarParts {
        // A 2 × 2 matrix is a sum of a scaled rotation and a scaled reflection (Blinn 1996);
        // the larger of the two decides, and their lengths give the singular values.
        let [a, c, b, d] = [self.linear.m11, self.linear.m21, self.linear.m12, self.linear.m22];
        let (proper_cos, proper_sin) = (0.5 * (a + d), 0.5 * (c - b));
        let (mirror_cos, mirror_sin) = (0.5 * (a - d), 0.5 * (c + b));
        let proper = proper_cos.hypot(proper_sin);
        let mirror = mirror_cos.hypot(mirror_sin);
        let reflected = mirror > proper;
        let angle_rad =
            if reflected { mirror_sin.atan2(mirror_cos) } else { proper_sin.atan2(proper_cos) };
        let orthogonal = Self::rigid(angle_rad, reflected, Vector2::zeros()).linear;
        let stretch = orthogonal.transpose() * self.linear;
        PlanarParts {
            angle_rad,
            reflected,
            stretch: 0.5 * (stretch + stretch.transpose()),
            major_scale: proper + mirror,
            minor_scale: (proper - mirror).abs(),
        }
    }

    /// The map from target to source.
    ///
    /// # Errors
    ///
    /// [`GeometryError::Singular`] when the image is a line or a point to within round-off,
    /// [`GeometryError::NonFinite`].
    pub fn inverse(&self) -> Result<Self, GeometryError> {
        finite(self.linear.iter().chain(self.translation_mm.iter()), "planar map")?;
        let PlanarParts { major_scale, minor_scale, .. } = self.parts();
        let singular = GeometryError::Singular { major_scale, minor_scale };
        // Round-off of the smaller scale is a few 2⁻⁵² of the larger.
        if minor_scale <= 4.0 * f64::EPSILON * major_scale {
            return Err(singular);
        }
        let linear = self.linear.try_inverse().ok_or(singular)?;
        Ok(Self { linear, translation_mm: -(linear * self.translation_mm) })
    }

    /// The map as a rigid motion.
    ///
    /// # Errors
    ///
    /// [`GeometryError::NotRigid`] if it reflects, or if a scale differs from 1 by more than
    /// `max_scale_error` (a ratio; 1e-12 allows for round-off).
    pub fn to_isometry(&self, max_scale_error: f64) -> Result<Isometry2<f64>, GeometryError> {
        let PlanarParts { angle_rad, reflected, major_scale, minor_scale, .. } = self.parts();
        let error = (major_scale - 1.0).abs().max((minor_scale - 1.0).abs());
        let rigid = error <= max_scale_error && !reflected;
        if !rigid {
            let determinant = self.linear.determinant();
            return Err(GeometryError::NotRigid { major_scale, minor_scale, determinant });
        }
        let translation = Translation2::from(self.translation_mm);
        Ok(Isometry2::from_parts(translation, UnitComplex::new(angle_rad)))
    }
}

impl From<Isometry2<f64>> for PlanarMap {
    fn from(target_from_source: Isometry2<f64>) -> Self {
        Self {
            linear: target_from_source.rotation.to_rotation_matrix().into_inner(),
            translation_mm: target_from_source.translation.vector,
        }
    }
}

impl Mul for PlanarMap {
    type Output = Self;

    /// The map that applies `source_from_other` first.
    fn mul(self, source_from_other: Self) -> Self {
        Self {
            linear: self.linear * source_from_other.linear,
            translation_mm: self.linear * source_from_other.translation_mm + self.translation_mm,
        }
    }
}
