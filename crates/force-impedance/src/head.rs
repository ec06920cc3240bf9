mod kinematics;

use nalgebra::Vector3;

use crate::ForceImpedanceError;
use crate::error::{require, require_not_negative, require_positive};
use crate::scalar::norm;

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
