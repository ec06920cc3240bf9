use nalgebra::{Point2, Point3, Unit, Vector3};

use crate::foot::foot_of_ball;
use crate::nominal::NominalFoot;
use crate::{Nominal, ProbeError};

/// Newton steps; each squares the error.
const MAX_STEPS: usize = 50;
/// Steps below this are round-off.
const LAST_STEP_MM: f64 = 1e-12;

/// A guide point of document \[E\]: where a ball is to be sent, moving along z, and where it will touch the
/// part as drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GuidePoint {
    /// G, on the part as drawn.
    pub guide_mm: Point3<f64>,
    /// Ball's centre above it, O.
    pub center_mm: Point3<f64>,
    /// Contact, A = O − r n.
    pub point_mm: Point3<f64>,
    /// Unit normal at the contact, towards the ball.
    pub normal: Unit<Vector3<f64>>,
    /// Whether the contact is within the part's aperture.
    pub inside_aperture: bool,
}

/// The guide point at `guide_mm`, with a ball of radius `tip_radius_mm` looked for from the height `from_z_mm`.
///
/// # Errors
///
/// With `index` as the touch they blame: [`ProbeError::NoGuide`] where a ball moving along z does not meet the
/// part, [`ProbeError::TipTooLarge`], [`ProbeError::InvalidTip`].
pub fn guide_point(
    nominal: &Nominal,
    tip_radius_mm: f64,
    guide_mm: Point2<f64>,
    from_z_mm: f64,
    index: usize,
) -> Result<GuidePoint, ProbeError> {
    if !(tip_radius_mm >= 0.0 && tip_radius_mm.is_finite()) {
        return Err(ProbeError::InvalidTip { radius_mm: tip_radius_mm });
    }
    let met = |radius_mm: f64| {
        meet_along_z(nominal, radius_mm, guide_mm, from_z_mm).ok_or(ProbeError::NoGuide { index })
    };
    let (on_part_mm, _) = met(0.0)?;
    let (center_mm, _) = met(tip_radius_mm)?;
    let foot = foot_of_ball(nominal, tip_radius_mm, index, &center_mm)?;
    Ok(GuidePoint {
        guide_mm: on_part_mm,
        center_mm,
        point_mm: foot.point_mm,
        normal: foot.normal,
        inside_aperture: foot.inside_aperture,
    })
}

/// Where a ball that moves along z at `guide_mm` meets the nominal part, looked for from
/// `from_z_mm`: its centre, and the foot under it.
pub(crate) fn meet_along_z(
    nominal: &Nominal,
    tip_radius_mm: f64,
    guide_mm: Point2<f64>,
    from_z_mm: f64,
) -> Option<(Point3<f64>, NominalFoot)> {
    let mut center = Point3::new(guide_mm.x, guide_mm.y, from_z_mm);
    for _ in 0..MAX_STEPS {
        let foot = nominal.foot(&center).ok()?;
        // The distance grows along z by the normal's share of it.
        let step = (tip_radius_mm - foot.distance_mm) / foot.normal.z;
        if !step.is_finite() {
            return None;
        }
        center.z += step;
        if step.abs() <= LAST_STEP_MM * (1.0 + center.z.abs()) {
            let foot = nominal.foot(&center).ok()?;
            return Some((center, foot));
        }
    }
    None
}
