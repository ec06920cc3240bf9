//! A head that was checked, and where it stands with its tip at a point.

use nalgebra::{Matrix4x3, Point3, Vector3};

use super::{Head, HeadGeometry, HeadLimits, check_geometry, check_limits};
use crate::ForceImpedanceError;
use crate::cofactor::gram_spread;
use crate::pose::{HeadPose, STRAIGHT};
use crate::scalar::is_finite;

/// Below this ratio of singular values a tilt of the head changes no leg by more than round-off
/// of its reading.
const MIN_RELATIVE_SPREAD: f64 = 1e-6;

impl Head {
    /// Checks dimensions and limits.
    ///
    /// # Errors
    ///
    /// [`ForceImpedanceError::InvalidSetting`], [`ForceImpedanceError::NotAUnitVector`], and
    /// [`ForceImpedanceError::LegsDoNotHold`] when the legs leave a tilt free.
    pub fn new(geometry: HeadGeometry, limits: HeadLimits) -> Result<Self, ForceImpedanceError> {
        check_geometry(&geometry)?;
        check_limits(&limits)?;
        let joint = |radius_mm: f64, height_mm: f64| {
            geometry.leg_angles_rad.map(|angle| {
                Vector3::new(radius_mm * libm::cos(angle), height_mm, radius_mm * libm::sin(angle))
            })
        };
        let head = Self {
            geometry,
            limits,
            brackets_mm: joint(geometry.bracket_radius_mm, -geometry.plane_to_joint_mm),
            arms_mm: joint(geometry.head_radius_mm, 0.0),
            tilt_cosine: libm::cos(limits.tilt_rad),
        };
        let start = HeadPose::of(&head, &head.start_tip_mm().coords);
        let relative_spread = gram_spread(&start.length_gradients(&head));
        if relative_spread.is_nan() || relative_spread < MIN_RELATIVE_SPREAD {
            return Err(ForceImpedanceError::LegsDoNotHold { relative_spread });
        }
        Ok(head)
    }

    /// Dimensions.
    #[must_use]
    pub const fn geometry(&self) -> &HeadGeometry {
        &self.geometry
    }

    /// Limits of travel.
    #[must_use]
    pub const fn limits(&self) -> &HeadLimits {
        &self.limits
    }

    /// Tip of the straight head, `(0, −L1 − L2, 0)`.
    #[inline]
    #[must_use]
    pub fn start_tip_mm(&self) -> Point3<f64> {
        let reach_mm = self.geometry.tip_to_plane_mm + self.geometry.plane_to_joint_mm;
        Point3::from(STRAIGHT * reach_mm)
    }

    /// The pose that brings the tip to a point of frame Y: inverse kinematics.
    ///
    /// The tip lands on the point to round-off: `l4 = |M1| − L1`, the axis along `O_Y M1`.
    ///
    /// # Errors
    ///
    /// [`ForceImpedanceError::NotFinite`], [`ForceImpedanceError::TiltOutOfRange`],
    /// [`ForceImpedanceError::AxialOutOfRange`], [`ForceImpedanceError::LegOutOfRange`].
    #[inline]
    pub fn pose_at(&self, tip_mm: &Point3<f64>) -> Result<HeadPose, ForceImpedanceError> {
        if !is_finite(&tip_mm.coords) {
            let known = [tip_mm.x, tip_mm.y, tip_mm.z].iter().take_while(|c| c.is_finite()).count();
            let (quantity, index) = ("tip coordinate", known + 1);
            return Err(ForceImpedanceError::NotFinite { quantity, index });
        }
        let pose = HeadPose::of(self, &tip_mm.coords);
        if self.allows(&pose) { Ok(pose) } else { Err(self.reason(&pose)) }
    }

    /// Whether a pose is within the limits, for those who need no reason.
    #[inline]
    pub(crate) fn allows(&self, pose: &HeadPose) -> bool {
        let [l1, l2, l3, l4] = pose.lengths_mm;
        let [shortest_mm, longest_mm] = self.limits.leg_mm;
        let leg = |l: f64| l >= shortest_mm && l <= longest_mm;
        let axial = l4 >= self.limits.axial_mm[0] && l4 <= self.limits.axial_mm[1];
        -pose.axis.y >= self.tilt_cosine && axial && leg(l1) && leg(l2) && leg(l3)
    }

    /// Why a pose is not within the limits.
    #[cold]
    fn reason(&self, pose: &HeadPose) -> ForceImpedanceError {
        let tilt_rad = pose.tilt_rad();
        let [l1, l2, l3, l4] = pose.lengths_mm;
        let upright = -pose.axis.y >= self.tilt_cosine;
        if !upright {
            return ForceImpedanceError::TiltOutOfRange { tilt_rad, max_rad: self.limits.tilt_rad };
        }
        let [min_mm, max_mm] = self.limits.axial_mm;
        if l4 < min_mm || l4 > max_mm {
            return ForceImpedanceError::AxialOutOfRange { length_mm: l4, min_mm, max_mm };
        }
        let [min_mm, max_mm] = self.limits.leg_mm;
        let fits = |l: f64| l >= min_mm && l <= max_mm;
        let (leg, length_mm) = match [fits(l1), fits(l2)] {
            [false, _] => (1, l1),
            [_, false] => (2, l2),
            _ => (3, l3),
        };
        ForceImpedanceError::LegOutOfRange { leg, length_mm, min_mm, max_mm }
    }

    /// `∂(l1, l2, l3, l4)/∂tip` at a pose, `4×3`, mm per mm.
    #[inline]
    #[must_use]
    pub fn leg_jacobian(&self, pose: &HeadPose) -> Matrix4x3<f64> {
        let [a, b, c, u] = pose.length_gradients(self);
        Matrix4x3::new(a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z, u.x, u.y, u.z)
    }
}
