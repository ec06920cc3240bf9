use nalgebra::Point3;

use crate::nominal::NominalFoot;
use crate::{Nominal, ProbeError};

/// A ball further from the surface than this, and than three of its radii, did not touch it.
const MAX_GAP_MM: f64 = 10.0;
/// The same in radii of the ball.
const MAX_GAP_RADII: f64 = 3.0;

/// Nominal point under a ball, which must be near it and may not be larger than the hollow there.
pub(crate) fn foot_of_ball(
    nominal: &Nominal,
    tip_radius_mm: f64,
    index: usize,
    center_mm: &Point3<f64>,
) -> Result<NominalFoot, ProbeError> {
    let too_large = |at: &Point3<f64>| -> Result<(), ProbeError> {
        if nominal.is_faceted() {
            return Ok(());
        }
        let Ok([major, _]) = nominal.curvatures_per_mm(at) else { return Ok(()) };
        if tip_radius_mm * major < 1.0 {
            return Ok(());
        }
        let (radius_mm, hollow_radius_mm) = (tip_radius_mm, major.recip());
        Err(ProbeError::TipTooLarge { index, radius_mm, hollow_radius_mm })
    };
    let foot = match nominal.foot(center_mm) {
        Ok(foot) => foot,
        Err(source) => {
            // A ball that is too large comes to rest where its centre has several feet, or none.
            too_large(center_mm)?;
            return Err(ProbeError::NoFoot { index, source });
        }
    };
    too_large(&foot.point_mm)?;
    let gap_mm = foot.distance_mm - tip_radius_mm;
    let limit_mm = MAX_GAP_MM.max(MAX_GAP_RADII * tip_radius_mm);
    if gap_mm.abs() > limit_mm {
        return Err(ProbeError::FarFromSurface { index, gap_mm, limit_mm, far: 1, of: 1 });
    }
    Ok(foot)
}
