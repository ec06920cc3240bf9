//! What a linear map does to shapes: scales, shears, and whether it mirrors.

use nalgebra::{SMatrix, SVector};

use crate::decompose::singular;
use crate::motion::axis_pairs;
use crate::statistics::ratio;
use crate::{FrameMap, Handedness};

/// Scales and shears of a linear map.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Shape<const D: usize> {
    /// Largest and smallest stretch of any direction: the singular values, the largest first.
    pub principal_scales: SVector<f64, D>,
    /// Directions of the source frame that are stretched so, one per column.
    pub principal_directions: SMatrix<f64, D, D>,
    /// Stretch of each axis of the source frame.
    pub axis_scales: SVector<f64, D>,
    /// By how much the right angle between two axes of the source frame closes, in rad: `[xy]`
    /// planar, `[xy, xz, yz]` spatial.
    pub shears_rad: Vec<f64>,
    /// Geometric mean of the principal scales.
    pub mean_scale: f64,
    /// Nearest orthogonal matrix (polar decomposition); it mirrors where the map does.
    pub rotation: SMatrix<f64, D, D>,
    /// Whether the map mirrors.
    pub handedness: Handedness,
}

/// Scales and shears of `map`, for a diagnosis of the affine transform.
#[must_use]
pub fn shape_of<const D: usize>(map: &FrameMap<D>) -> Shape<D> {
    let svd = singular(&map.linear);
    Shape {
        principal_scales: svd.values,
        principal_directions: svd.v,
        axis_scales: SVector::from_fn(|k, _| map.linear.column(k).norm()),
        shears_rad: axis_pairs(D).map(|(a, b)| closing_angle(&map.linear, a, b)).collect(),
        mean_scale: svd.values.product().powf(ratio(D).recip()),
        rotation: svd.u * svd.v.transpose(),
        handedness: map.handedness(),
    }
}

/// π/2 minus the angle between the images of two axes.
fn closing_angle<const D: usize>(linear: &SMatrix<f64, D, D>, a: usize, b: usize) -> f64 {
    let (first, second) = (linear.column(a), linear.column(b));
    let dot = first.dot(&second);
    let square = first.norm_squared() * second.norm_squared() - dot * dot;
    dot.atan2(square.max(0.0).sqrt())
}
