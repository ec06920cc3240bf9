use nalgebra::{Point3, Vector4};

use crate::cofactor::{least_squares, orthogonal};
use crate::scalar::norm;
use crate::{ForceImpedanceError, Head, HeadPose};

/// Iterations after which lengths count as fitting no pose; a start at the far end of the
/// workspace takes about eight.
const MAX_ITERATIONS: usize = 50;
/// A step that moves the tip by less than round-off of a reach of some 10³ mm.
const STEP_TOL_MM: f64 = 1e-11;

/// A pose found from four lengths, and how well they agree with it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ForwardPose {
    /// The pose whose lengths are nearest to those given (least squares).
    pub pose: HeadPose,
    /// What four lengths say of three degrees of freedom: the component of `given − fitted` along
    /// the direction that no motion of the head can make.
    ///
    /// Zero when the lengths agree. At the straight head that direction is `(1, 1, 1, 0)/√3`.
    pub consistency_mm: f64,
    /// That direction, a unit vector in the space of the four lengths.
    pub consistency_direction: Vector4<f64>,
}

impl Head {
    /// The pose that four lengths belong to: forward kinematics.
    ///
    /// # Errors
    ///
    /// [`ForceImpedanceError::NotFinite`], the out-of-range errors of [`Head::pose_at`], and
    /// [`ForceImpedanceError::ForwardNotConverged`] when no pose is near the lengths.
    pub fn pose_of_lengths(
        &self,
        lengths_mm: &[f64; 4],
    ) -> Result<ForwardPose, ForceImpedanceError> {
        if let Some(i) = lengths_mm.iter().position(|l| !l.is_finite()) {
            return Err(ForceImpedanceError::NotFinite { quantity: "length", index: i + 1 });
        }
        let [_, _, _, axial_mm] = *lengths_mm;
        let straight = self.start_tip_mm();
        let start_mm =
            straight * ((axial_mm + self.geometry.tip_to_plane_mm) / norm(&straight.coords));
        let mut pose = self.pose_at(&start_mm)?;
        let mut step_mm = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            let tip_mm = self.forward_step(&pose, lengths_mm);
            step_mm = norm(&(tip_mm - pose.tip_mm));
            pose = self.pose_at(&tip_mm)?;
            if step_mm <= STEP_TOL_MM {
                return Ok(self.judged(pose, lengths_mm));
            }
        }
        Err(ForceImpedanceError::ForwardNotConverged { step_mm, iterations: MAX_ITERATIONS })
    }

    /// One Gauss-Newton step from a pose towards four lengths.
    #[inline]
    pub(crate) fn forward_step(&self, from: &HeadPose, lengths_mm: &[f64; 4]) -> Point3<f64> {
        from.tip_mm + least_squares(&from.length_gradients(self), &misfit(from, lengths_mm))
    }

    fn judged(&self, pose: HeadPose, lengths_mm: &[f64; 4]) -> ForwardPose {
        let direction = orthogonal(&pose.length_gradients(self));
        let consistency_mm = direction.dot(&Vector4::from(misfit(&pose, lengths_mm)));
        ForwardPose { pose, consistency_mm, consistency_direction: direction }
    }
}

#[inline]
fn misfit(pose: &HeadPose, lengths_mm: &[f64; 4]) -> [f64; 4] {
    let ([a, b, c, d], [e, f, g, h]) = (lengths_mm, pose.lengths_mm);
    [a - e, b - f, c - g, d - h]
}
