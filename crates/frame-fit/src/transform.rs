//! The families of transforms, each nested in the next.

use std::fmt;

/// Family of transforms; each contains the ones before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Transform {
    /// The points are claimed to be in one frame already; nothing is estimated.
    None,
    /// Translation only: right where the source frame was built parallel to the target frame.
    Translation,
    /// Rotation and translation.
    #[default]
    Rigid,
    /// Rigid with one scale factor.
    Similarity,
    /// Any linear map with a translation.
    Affine,
}

impl Transform {
    /// Every family, the smallest first.
    pub const ALL: [Self; 5] =
        [Self::None, Self::Translation, Self::Rigid, Self::Similarity, Self::Affine];

    /// Number of parameters in `dimension` 2 or 3.
    #[must_use]
    pub const fn parameter_count(self, dimension: usize) -> usize {
        let rotations = dimension * (dimension - 1) / 2;
        match self {
            Self::None => 0,
            Self::Translation => dimension,
            Self::Rigid => dimension + rotations,
            Self::Similarity => dimension + rotations + 1,
            Self::Affine => dimension + dimension * dimension,
        }
    }

    /// Fewest points that can determine the transform in `dimension` 2 or 3.
    #[must_use]
    pub const fn minimum_points(self, dimension: usize) -> usize {
        match self {
            Self::None => 0,
            Self::Translation => 1,
            Self::Rigid | Self::Similarity => dimension,
            Self::Affine => dimension + 1,
        }
    }

    /// Dimension that the points must span about their centroid.
    pub(crate) const fn required_span(self, dimension: usize) -> usize {
        match self {
            Self::None | Self::Translation => 0,
            Self::Rigid | Self::Similarity => dimension - 1,
            Self::Affine => dimension,
        }
    }

    /// Whether a rotation is among the parameters.
    #[must_use]
    pub const fn has_rotation(self) -> bool {
        matches!(self, Self::Rigid | Self::Similarity | Self::Affine)
    }

    /// Whether a translation is among the parameters.
    #[must_use]
    pub const fn has_translation(self) -> bool {
        !matches!(self, Self::None)
    }
}

impl fmt::Display for Transform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::None => "none",
            Self::Translation => "translation",
            Self::Rigid => "rigid",
            Self::Similarity => "similarity",
            Self::Affine => "affine",
        })
    }
}

/// Whether a map keeps right-handed frames right-handed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Handedness {
    /// Determinant positive: a rotation, perhaps scaled.
    #[default]
    Proper,
    /// Determinant negative: a rotation with a reflection.
    Improper,
}

impl Handedness {
    /// The other one.
    #[must_use]
    pub fn opposite(self) -> Self {
        match self {
            Self::Proper => Self::Improper,
            Self::Improper => Self::Proper,
        }
    }
}

impl fmt::Display for Handedness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Proper => "proper",
            Self::Improper => "improper",
        })
    }
}
