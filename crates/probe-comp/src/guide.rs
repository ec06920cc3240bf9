use nalgebra::{Point2, Point3};

use crate::Nominal;
use crate::nominal::NominalFoot;

/// Newton steps; each squares the error.
const MAX_STEPS: usize = 50;
/// Steps below this are round-off.
const LAST_STEP_MM: f64 = 1e-12;

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
