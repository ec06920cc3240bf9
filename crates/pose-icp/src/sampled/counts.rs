//! How many points the method takes: document \[D\], (15)–(19) and its figure of the touches.

use std::f64::consts::PI;

use nalgebra::Point2;

/// How far around a touch the model is sampled anew for the second level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Patch {
    /// A square of one coarse spacing: c = 1.
    #[default]
    OneSpacing,
    /// A square of two coarse spacings: c = 4.
    TwoSpacings,
}

impl Patch {
    /// Side of the square over the coarse spacing.
    pub(super) fn spacings(self) -> f64 {
        match self {
            Self::OneSpacing => 1.0,
            Self::TwoSpacings => 2.0,
        }
    }
}

/// Points of a disc sampled on a square grid, (15) and (17): `π D²/(4 Δw²)`.
pub(super) fn disc_points(diameter_mm: f64, spacing_mm: f64) -> f64 {
    0.25 * PI * (diameter_mm / spacing_mm).powi(2)
}

/// Points of all patches, (16): `c Nm (Δw/Δw1)²`.
pub(super) fn patch_points(touches: usize, patch: Patch, coarse_mm: f64, fine_mm: f64) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let touches = touches as f64;
    touches * (patch.spacings() * coarse_mm / fine_mm).powi(2)
}

/// Ratio `Δw/Δw1` for which both levels together have the fewest points:
/// `(π D²/(4 c Nm Δw1²))^¼`.
///
/// Document \[D\] itself takes 1000 where this is 122 (c = 4) or 172 (c = 1).
#[must_use]
pub fn optimal_ratio(diameter_mm: f64, touches: usize, patch: Patch, fine_mm: f64) -> f64 {
    let per_ratio = patch_points(touches, patch, 1.0, 1.0);
    (disc_points(diameter_mm, fine_mm) / per_ratio).powf(0.25)
}

/// Where document \[D\] touches: the centre, four points at `k D/4` and four at `k D/2`.
///
/// `rim_ratio` is its k, below 1 where the part is bad near the rim; it takes 0.8. The points lie
/// on the axes, in the workpiece frame.
#[must_use]
pub fn measuring_points(diameter_mm: f64, rim_ratio: f64) -> [Point2<f64>; 9] {
    let [inner, outer] = [0.25, 0.5].map(|share| share * rim_ratio * diameter_mm);
    let at = |x: f64, y: f64| Point2::new(x, y);
    [
        at(0.0, 0.0),
        at(inner, 0.0),
        at(0.0, inner),
        at(-inner, 0.0),
        at(0.0, -inner),
        at(outer, 0.0),
        at(0.0, outer),
        at(-outer, 0.0),
        at(0.0, -outer),
    ]
}
