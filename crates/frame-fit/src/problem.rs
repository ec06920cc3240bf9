//! The fit as a least-squares problem, in coordinates about the centroids.

use least_squares::Problem;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use crate::motion::{self, Motion, Moved};
use crate::{FrameMap, PointPair, Transform};

/// Units in the last place of a coordinate that a transform of a point may lose.
const ROUND_OFF_ULPS: f64 = 8.0;

/// Whitened residuals `W (target − T·source)` of every pair.
///
/// Its points are motions of the images under a near map, about their centroid: residuals then
/// change by exactly what the motion says, however far the frames' origins are.
pub(crate) struct FitProblem<const D: usize> {
    points: Vec<Imaged<D>>,
    transform: Transform,
    pub(crate) motions: Vec<Motion>,
    near: FrameMap<D>,
    /// Weighted centroid of the images: the pivot of all motions.
    pub(crate) pivot_mm: SVector<f64, D>,
    /// Weighted sum of squares that rounding of the coordinates leaves of an exact fit.
    pub(crate) round_off_chi2: f64,
}

/// The image of a source point, from the pivot, and what it misses its partner by.
struct Imaged<const D: usize> {
    arm_mm: SVector<f64, D>,
    miss_mm: SVector<f64, D>,
    /// Per mm.
    whitening: SMatrix<f64, D, D>,
}

impl<const D: usize> FitProblem<D> {
    /// `near` is the map that the search starts from.
    pub(crate) fn new(pairs: &[PointPair<D>], transform: Transform, near: &FrameMap<D>) -> Self {
        let mut source_center_mm = SVector::zeros();
        let mut total = 0.0;
        for pair in pairs {
            let weight = pair.uncertainty.mean_weight_per_mm2();
            total += weight;
            source_center_mm += (pair.source_mm.coords - source_center_mm) * (weight / total);
        }
        let pivot_mm = near.linear * source_center_mm + near.translation_mm;
        let mut round_off_chi2 = 0.0;
        let imaged = |pair: &PointPair<D>| {
            let whitening = pair.uncertainty.whitening_per_mm().expect("checked");
            let largest_mm = [&pair.target_mm.coords, &pair.source_mm.coords, &near.translation_mm]
                .map(SVector::amax);
            let lost_mm =
                ROUND_OFF_ULPS * f64::EPSILON * largest_mm.into_iter().fold(0.0, f64::max);
            round_off_chi2 += (whitening.norm() * lost_mm).powi(2);
            let arm_mm = near.linear * (pair.source_mm.coords - source_center_mm);
            let miss_mm = (pair.target_mm.coords - pivot_mm) - arm_mm;
            Imaged { arm_mm, miss_mm, whitening }
        };
        Self {
            points: pairs.iter().map(imaged).collect(),
            transform,
            motions: motion::motions(transform, D),
            near: *near,
            pivot_mm,
            round_off_chi2,
        }
    }

    /// The near map after a motion.
    pub(crate) fn map(&self, moved: &Moved<D>) -> FrameMap<D> {
        moved.map(&self.pivot_mm).after(&self.near)
    }

    /// Whitened residuals after a motion.
    pub(crate) fn whitened(&self, at: &Moved<D>) -> DVector<f64> {
        let mut whitened = DVector::zeros(self.residual_count());
        self.residuals(at, &mut whitened);
        whitened
    }
}

impl<const D: usize> Problem for FitProblem<D> {
    type Point = Moved<D>;

    fn residual_count(&self) -> usize {
        D * self.points.len()
    }

    fn tangent_dim(&self) -> usize {
        self.motions.len()
    }

    fn residuals(&self, at: &Moved<D>, out: &mut DVector<f64>) {
        for (i, point) in self.points.iter().enumerate() {
            let left_mm = point.miss_mm - at.displacement(&point.arm_mm);
            out.fixed_rows_mut::<D>(D * i).copy_from(&(point.whitening * left_mm));
        }
    }

    fn jacobian(&self, at: &Moved<D>, out: &mut DMatrix<f64>) {
        for (i, point) in self.points.iter().enumerate() {
            let arm_mm = point.arm_mm + at.displacement(&point.arm_mm);
            for (column, motion) in self.motions.iter().enumerate() {
                let moved = point.whitening * motion.displacement(&arm_mm);
                out.fixed_view_mut::<D, 1>(D * i, column).copy_from(&-moved);
            }
        }
    }

    fn retract(&self, at: &Moved<D>, step: &DVector<f64>) -> Moved<D> {
        motion::finite(self.transform, &self.motions, step).after(at)
    }

    fn parameter_name(&self, index: usize) -> String {
        self.motions[index].name().to_owned()
    }
}
