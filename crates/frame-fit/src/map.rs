//! The estimated map itself.

use nalgebra::{
    Isometry2, Isometry3, Point, Rotation2, Rotation3, SMatrix, SVector, Translation2,
    Translation3, UnitComplex, UnitQuaternion,
};

use crate::Handedness;
use crate::decompose::{determinant, dynamic};

/// Largest deviation of `LᵀL` from the identity that still passes for a rotation.
const ORTHOGONAL_TOL: f64 = 1e-9;

/// `target = L · source + t`: the estimate of every family of transforms.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FrameMap<const D: usize> {
    /// The linear part `L`, dimensionless.
    pub linear: SMatrix<f64, D, D>,
    /// The translation `t`, in the target frame.
    pub translation_mm: SVector<f64, D>,
}

impl<const D: usize> FrameMap<D> {
    /// The map that leaves every point where it is.
    #[must_use]
    pub fn identity() -> Self {
        Self { linear: SMatrix::identity(), translation_mm: SVector::zeros() }
    }

    /// Image of a point of the source frame.
    #[must_use]
    pub fn apply(&self, source_mm: &Point<f64, D>) -> Point<f64, D> {
        Point::from(self.linear * source_mm.coords + self.translation_mm)
    }

    /// `self` after `first`.
    #[must_use]
    pub fn after(&self, first: &Self) -> Self {
        Self {
            linear: self.linear * first.linear,
            translation_mm: self.linear * first.translation_mm + self.translation_mm,
        }
    }

    /// Inverse map; `None` where the linear part is singular.
    #[must_use]
    pub fn inverse(&self) -> Option<Self> {
        let inverse = dynamic(&self.linear).try_inverse()?;
        let linear = SMatrix::from_column_slice(inverse.as_slice());
        Some(Self { linear, translation_mm: -(linear * self.translation_mm) })
    }

    /// Whether the map mirrors.
    #[must_use]
    pub fn handedness(&self) -> Handedness {
        if determinant(&self.linear) < 0.0 { Handedness::Improper } else { Handedness::Proper }
    }

    /// Rows of the homogeneous matrix, `D + 1` of them.
    #[must_use]
    pub fn homogeneous_rows(&self) -> Vec<Vec<f64>> {
        let mut rows: Vec<Vec<f64>> = (0..D)
            .map(|row| {
                let linear = self.linear.row(row);
                linear.iter().copied().chain([self.translation_mm[row]]).collect()
            })
            .collect();
        rows.push((0..=D).map(|column| if column == D { 1.0 } else { 0.0 }).collect());
        rows
    }

    fn is_orthogonal(&self) -> bool {
        (self.linear.transpose() * self.linear - SMatrix::identity()).amax() < ORTHOGONAL_TOL
    }
}

impl FrameMap<2> {
    /// The same map as a planar pose, when it is proper and has no scale.
    #[must_use]
    pub fn isometry(&self) -> Option<Isometry2<f64>> {
        let proper = self.is_orthogonal() && self.handedness() == Handedness::Proper;
        let rotation = Rotation2::from_matrix_unchecked(self.linear);
        proper.then(|| {
            Isometry2::from_parts(
                Translation2::from(self.translation_mm),
                UnitComplex::from_rotation_matrix(&rotation),
            )
        })
    }
}

impl FrameMap<3> {
    /// The same map as a pose, when it is proper and has no scale.
    #[must_use]
    pub fn isometry(&self) -> Option<Isometry3<f64>> {
        let proper = self.is_orthogonal() && self.handedness() == Handedness::Proper;
        let rotation = Rotation3::from_matrix_unchecked(self.linear);
        proper.then(|| {
            Isometry3::from_parts(
                Translation3::from(self.translation_mm),
                UnitQuaternion::from_rotation_matrix(&rotation),
            )
        })
    }
}

impl From<Isometry2<f64>> for FrameMap<2> {
    fn from(pose: Isometry2<f64>) -> Self {
        Self {
            linear: *pose.rotation.to_rotation_matrix().matrix(),
            translation_mm: pose.translation.vector,
        }
    }
}

impl From<Isometry3<f64>> for FrameMap<3> {
    fn from(pose: Isometry3<f64>) -> Self {
        Self {
            linear: *pose.rotation.to_rotation_matrix().matrix(),
            translation_mm: pose.translation.vector,
        }
    }
}
