//! How far the points spread, and what they leave free when they do not.

use nalgebra::{DMatrix, Point, SMatrix, SVector};

use crate::decompose::singular;
use crate::{FrameFitError, FreeMotion, PointPair, Transform};

/// No instrument tells such points apart: a hundredth of an atom.
const SMALLEST_SPREAD_MM: f64 = 1e-9;
/// Units in the last place of the largest coordinate that rounding may leave of a zero spread.
const ROUND_OFF_ULPS: f64 = 64.0;

/// Principal directions of a set of points about its centroid.
#[derive(Clone, Debug)]
pub(crate) struct Spread<const D: usize> {
    /// Root-mean-square distances along `directions`, the largest first.
    pub(crate) rms_mm: SVector<f64, D>,
    /// Unit vectors, one per column.
    pub(crate) directions: SMatrix<f64, D, D>,
    #[cfg(feature = "loop")]
    pub(crate) centroid_mm: Point<f64, D>,
    smallest_mm: f64,
}

impl<const D: usize> Spread<D> {
    pub(crate) fn of(points: impl ExactSizeIterator<Item = Point<f64, D>> + Clone) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "point counts are far below 2^53")]
        let count = points.len() as f64;
        let centroid_mm =
            points.clone().fold(SVector::zeros(), |sum: SVector<f64, D>, p| sum + p.coords) / count;
        let largest = points.clone().map(|p| p.coords.amax()).fold(0.0, f64::max);
        // Rows of zeros make room for `D` singular values of fewer points.
        let mut arms = DMatrix::zeros(points.len().max(D), D);
        for (row, point) in points.enumerate() {
            let arm = point.coords - centroid_mm;
            arms.fixed_view_mut::<1, D>(row, 0).copy_from(&arm.transpose());
        }
        let triangle = arms.qr().r();
        let svd = singular(&SMatrix::<f64, D, D>::from_column_slice(triangle.as_slice()));
        Self {
            rms_mm: svd.values / count.sqrt(),
            directions: svd.v,
            #[cfg(feature = "loop")]
            centroid_mm: Point::from(centroid_mm),
            smallest_mm: SMALLEST_SPREAD_MM.max(ROUND_OFF_ULPS * f64::EPSILON * largest),
        }
    }

    /// Number of directions along which the points extend.
    pub(crate) fn span(&self) -> usize {
        self.rms_mm.iter().filter(|s| **s > self.smallest_mm).count()
    }
}

/// Spread of the source points, after checking that they and the target points determine
/// `transform`.
pub(crate) fn check_spread<const D: usize>(
    pairs: &[PointPair<D>],
    transform: Transform,
) -> Result<Spread<D>, FrameFitError> {
    let source = Spread::of(pairs.iter().map(|p| p.source_mm));
    check_span(&source, transform)?;
    // An affine map may flatten; a rigid one cannot.
    if transform != Transform::Affine {
        check_span(&Spread::of(pairs.iter().map(|p| p.target_mm)), transform)?;
    }
    Ok(source)
}

fn check_span<const D: usize>(
    spread: &Spread<D>,
    transform: Transform,
) -> Result<(), FrameFitError> {
    let span = spread.span();
    if span >= transform.required_span(D) {
        return Ok(());
    }
    let direction = |k: usize| spread.directions.column(k).iter().copied().collect();
    let free = match (transform, span) {
        (Transform::Affine, _) => FreeMotion::MapAlong { direction: direction(span) },
        (_, 0) => FreeMotion::EveryRotation,
        _ => FreeMotion::RotationAbout { axis: direction(0) },
    };
    let spreads_mm = spread.rms_mm.iter().copied().collect();
    Err(FrameFitError::Degenerate { transform, spreads_mm, free })
}
