use nalgebra::{Matrix4x3, Point3, Vector3};

use crate::ForceImpedanceError;
use crate::cofactor::gram_spread;
use crate::error::{require, require_not_negative, require_positive};
use crate::pose::{HeadPose, STRAIGHT};
use crate::scalar::{is_finite, norm};

/// Below this ratio of singular values a tilt of the head changes no leg by more than round-off
/// of its reading.
const MIN_RELATIVE_SPREAD: f64 = 1e-6;
/// A declared direction with more than this is a slip, not round-off of its digits.
const UNIT_LENGTH_TOL: f64 = 1e-6;
/// At a right angle and beyond, the legs' brackets are above the joint.
const MAX_TILT_RAD: f64 = core::f64::consts::FRAC_PI_2;

/// Dimensions of the head, frame Y: origin in the joint, the straight tool along −y.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HeadGeometry {
    /// `L1`, from the tool's contact point to the plane of the legs.
    pub tip_to_plane_mm: f64,
    /// `L2`, from the plane of the legs to the joint, head straight.
    pub plane_to_joint_mm: f64,
    /// Radius of the legs' joints on the head, `r`.
    pub head_radius_mm: f64,
    /// Radius of the legs' joints on the bracket, `R_b`.
    pub bracket_radius_mm: f64,
    /// Directions of the legs in the xz plane, from x towards z.
    pub leg_angles_rad: [f64; 3],
    /// Weight of everything between load cells and tip.
    pub weight_n: f64,
    /// Centre of gravity on the tool's axis, from the joint, head straight.
    ///
    /// It moves along with the axial unit.
    pub center_of_gravity_mm: f64,
    /// Unit vector along which things fall.
    pub gravity_direction: Vector3<f64>,
}

/// Limits of the legs' travel.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HeadLimits {
    /// Shortest and longest of the three legs.
    pub leg_mm: [f64; 2],
    /// Shortest and longest of the axial unit, `|O_T O_Y|`.
    pub axial_mm: [f64; 2],
    /// Largest tilt of the tool from −y.
    pub tilt_rad: f64,
}

impl HeadLimits {
    /// A tenth to twice the length of each leg of the straight head, half to twice of the axial
    /// unit, and 45°: what a head could do, for reading logs rather than for driving it.
    #[must_use]
    pub fn wide(geometry: &HeadGeometry) -> Self {
        let leg_mm = (geometry.bracket_radius_mm - geometry.head_radius_mm).abs();
        let axial_mm = geometry.plane_to_joint_mm;
        Self {
            leg_mm: [0.1 * leg_mm, 2.0 * leg_mm],
            axial_mm: [0.5 * axial_mm, 2.0 * axial_mm],
            tilt_rad: core::f64::consts::FRAC_PI_4,
        }
    }
}

/// A polishing head on three radial legs and one axial unit; checked once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Head {
    pub(crate) geometry: HeadGeometry,
    pub(crate) limits: HeadLimits,
    /// Joints on the bracket.
    pub(crate) brackets_mm: [Vector3<f64>; 3],
    /// Joints on the straight head, from the middle of their plane.
    pub(crate) arms_mm: [Vector3<f64>; 3],
    /// Cosine of the largest tilt.
    pub(crate) tilt_cosine: f64,
}

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

fn check_geometry(g: &HeadGeometry) -> Result<(), ForceImpedanceError> {
    require_positive("tip_to_plane_mm", g.tip_to_plane_mm)?;
    require_positive("plane_to_joint_mm", g.plane_to_joint_mm)?;
    require_positive("head_radius_mm", g.head_radius_mm)?;
    require_positive("bracket_radius_mm", g.bracket_radius_mm)?;
    require_not_negative("weight_n", g.weight_n)?;
    require(
        g.center_of_gravity_mm.is_finite(),
        "center_of_gravity_mm",
        g.center_of_gravity_mm,
        "finite",
    )?;
    for angle in g.leg_angles_rad {
        require(angle.is_finite(), "leg angle (rad)", angle, "finite")?;
    }
    let gap_mm = (g.bracket_radius_mm - g.head_radius_mm).abs();
    require(
        gap_mm > 1e-6 * g.bracket_radius_mm,
        "bracket_radius_mm − head_radius_mm",
        gap_mm,
        "the length of the legs, not zero",
    )?;
    let length = norm(&g.gravity_direction);
    let is_unit = (length - 1.0).abs() < UNIT_LENGTH_TOL;
    if !is_unit {
        return Err(ForceImpedanceError::NotAUnitVector { vector: "gravity_direction", length });
    }
    Ok(())
}

fn check_limits(l: &HeadLimits) -> Result<(), ForceImpedanceError> {
    require_positive("shortest leg_mm", l.leg_mm[0])?;
    require(l.leg_mm[1] > l.leg_mm[0], "longest leg_mm", l.leg_mm[1], "above the shortest")?;
    require_positive("shortest axial_mm", l.axial_mm[0])?;
    require(
        l.axial_mm[1] > l.axial_mm[0],
        "longest axial_mm",
        l.axial_mm[1],
        "above the shortest",
    )?;
    require(
        l.tilt_rad > 0.0 && l.tilt_rad < MAX_TILT_RAD,
        "tilt_rad",
        l.tilt_rad,
        "above 0 and below π/2",
    )
}
