//! What the machine frame is good for: whether an axis is off its declared place, or the places that
//! make the frame are.
//!
//! The frame comes from nominal places: of the stations, or of the reflectors where a tracker gives
//! points. A location error below the uncertainty of that frame is none of the axis.

use nalgebra::{Matrix3, Matrix3x6, Matrix4, Matrix6, Vector3, Vector4};
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use crate::{AxisError, AxisLocation, RotaryAxis};

/// Chance that an axis in its place seems to be off it.
const FALSE_ALARM: f64 = 1e-3;

/// Uncertainty of the frame about the origin of the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    /// Of a motion of all of it, displacement before rotation.
    motion: Matrix6<f64>,
    /// Of where it has the axis: of its four location errors.
    pub(crate) covariance: Matrix4<f64>,
    /// Of the scatter that it rests on; `None` where that is declared.
    dof: Option<usize>,
}

/// Root mean square of motion errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motion {
    displacement_mm: f64,
    rotation_rad: f64,
}

impl Motion {
    /// Of errors in the fixed frame without what the place of the axis makes of them.
    pub(crate) fn of(errors: &[AxisError], location: &AxisLocation) -> Option<Self> {
        let left = errors.iter().map(|e| e.error - location.share(e.angle_rad));
        let (mut displacement, mut rotation) = (0.0, 0.0);
        for left in left {
            displacement += left.fixed_rows::<3>(0).norm_squared() / 3.0;
            rotation += left.fixed_rows::<3>(3).norm_squared() / 3.0;
        }
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let n = errors.len() as f64;
        let size = |sum: f64| (sum / n).sqrt();
        let motion = Self { displacement_mm: size(displacement), rotation_rad: size(rotation) };
        (motion.displacement_mm.is_finite() && motion.rotation_rad.is_finite()).then_some(motion)
    }
}

impl Frame {
    /// Of the rigid fit of places, given from the origin of the axis, of which each coordinate has
    /// this standard uncertainty; `None` where they leave a motion free.
    pub(crate) fn of_places(
        axis: &RotaryAxis,
        from_origin_mm: &[Vector3<f64>],
        sigma_mm: f64,
        dof: Option<usize>,
    ) -> Option<Self> {
        let mut information = Matrix6::zeros();
        for place in from_origin_mm {
            let by_motion = by_motion(place);
            information += by_motion.tr_mul(&by_motion);
        }
        let all = information.cholesky()?.inverse() * sigma_mm.powi(2);
        let [first, second] = axis.letter.across();
        let of = [first, second, 3 + first, 3 + second];
        let covariance = Matrix4::from_fn(|i, j| all[(of[i], of[j])]);
        Some(Self { motion: all, covariance, dof })
    }

    /// Covariance that it gives a place, from the origin of the axis and along the machine's axes, beside
    /// that of the place in it.
    pub(crate) fn of_place(&self, from_origin_mm: &Vector3<f64>) -> Matrix3<f64> {
        let by_motion = by_motion(from_origin_mm);
        by_motion * self.motion * by_motion.transpose()
    }

    /// Covariance that it gives a reflector on the axis, which stands where it stood at the first angle.
    pub(crate) fn of_mount(
        &self,
        axis: &RotaryAxis,
        first_rad: f64,
        place_mm: &Vector3<f64>,
    ) -> Matrix3<f64> {
        let turned = axis.rotation(first_rad).to_rotation_matrix().into_inner();
        turned.tr_mul(&self.of_place(&(turned * place_mm))) * turned
    }

    /// Whether a location, found in the frame as though that were exact, is off its declared place by
    /// more than the frame is uncertain, and than motion errors of this size may seem to move it.
    pub(crate) fn is_exceeded(&self, location: &AxisLocation, motion: Option<Motion>) -> bool {
        let motion = motion.unwrap_or(Motion { displacement_mm: 0.0, rotation_rad: 0.0 });
        let (e, w) = (motion.displacement_mm.powi(2), motion.rotation_rad.powi(2));
        let moved = Matrix4::from_diagonal(&Vector4::new(e, e, w, w));
        let Some(factor) = (location.covariance + self.covariance + moved).cholesky() else {
            return true;
        };
        let square = location.errors.dot(&factor.solve(&location.errors));
        let p_value = match self.dof {
            None => ChiSquared::new(4.0).map_or(0.0, |law| law.sf(square)),
            Some(dof) => {
                let dof = f64::from(u32::try_from(dof).unwrap_or(u32::MAX));
                FisherSnedecor::new(4.0, dof).map_or(0.0, |law| law.sf(square / 4.0))
            }
        };
        p_value < FALSE_ALARM
    }
}

/// What a motion of the frame about the origin does to a place.
fn by_motion(place: &Vector3<f64>) -> Matrix3x6<f64> {
    let mut by_motion = Matrix3x6::zeros();
    by_motion.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::identity());
    by_motion.fixed_view_mut::<3, 3>(0, 3).copy_from(&-place.cross_matrix());
    by_motion
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector6};

    use super::*;
    use crate::AxisLetter;
    use crate::location::located;

    /// Of numbers of size 1: 2⁻⁵² and some ten operations, over the square root of a sum of squares.
    const ROUND_OFF: f64 = 1e-14;

    /// What the place of an axis makes of its errors is no motion; what is beside it counts in full.
    #[test]
    fn a_place_is_no_motion() {
        let direction = Vector3::new(0.02, 1.0, -0.01);
        let axis = RotaryAxis::new(AxisLetter::B, Point3::new(4.0, 3.0, 7.0), direction).unwrap();
        let place = Vector4::new(0.7, -0.4, 0.2, 0.5);
        let location = located(axis, -1.2, place, Matrix4::identity());
        let beside = |displacement_mm: f64, rotation_rad: f64| {
            let [e, w] = [displacement_mm, rotation_rad];
            let error = |k: u32| {
                let angle_rad = 0.4 * f64::from(k) - 1.2;
                let error = location.share(angle_rad) + Vector6::new(e, -e, e, -w, w, w);
                AxisError { angle_rad, error, covariance: Matrix6::identity() }
            };
            Motion::of(&(0..7).map(error).collect::<Vec<_>>(), &location).unwrap()
        };
        for (displacement_mm, rotation_rad) in [(0.0, 0.0), (0.3, 0.0), (0.0, 0.1)] {
            let found = beside(displacement_mm, rotation_rad);
            assert!((found.displacement_mm - displacement_mm).abs() < ROUND_OFF, "{found:?}");
            assert!((found.rotation_rad - rotation_rad).abs() < ROUND_OFF, "{found:?}");
        }
    }
}
