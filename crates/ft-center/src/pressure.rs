//! Centre of pressure of one wrench: \[A\] (1.2) to (1.11).

use geometry::Wrench;
use nalgebra::Point2;

use crate::{FtCenterError, error::require_positive};

/// Where one wrench meets the contact plane.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PressurePoint {
    /// Centre of pressure in the contact plane, sensor frame.
    pub position_mm: Point2<f64>,
    /// Moment about the sensor's z that the force at this point does not explain:
    /// `Mz − (x Fy − y Fx)`, the friction couple of a spinning pad.
    pub free_moment_nmm: f64,
}

/// Centre of pressure of one wrench in the plane `z = z0`: (1.11) of \[A\].
///
/// `x = (z0 Fx − My) / Fz`, `y = (Mx + z0 Fy) / Fz`. `Fz` may have either sign: a press reads
/// negative on a sensor whose z points out of the platform. `Mz` is left out, because the
/// friction couple of a spinning pad would move the answer; it comes back as the free moment.
///
/// # Errors
///
/// [`FtCenterError::NotFinite`] with the position in `[fx, fy, fz, mx, my, mz]`,
/// [`FtCenterError::InvalidHeight`], [`FtCenterError::NoContact`] when `|Fz| < min_fz_n`, and
/// [`FtCenterError::NotPositive`] for the gate itself.
pub fn center_of_pressure(
    wrench: &Wrench,
    z0_mm: f64,
    min_fz_n: f64,
) -> Result<PressurePoint, FtCenterError> {
    require_positive(min_fz_n, "min_fz_n")?;
    if !z0_mm.is_finite() {
        return Err(FtCenterError::InvalidHeight { z0_mm });
    }
    if let Some(index) = wrench.to_vector().iter().position(|v| !v.is_finite()) {
        return Err(FtCenterError::NotFinite { index });
    }
    let fz_n = wrench.force_n.z;
    if fz_n.abs() < min_fz_n {
        return Err(FtCenterError::NoContact { fz_n, min_fz_n });
    }
    Ok(pressure_point(wrench, z0_mm))
}

/// (1.11) for a wrench already known to be in contact.
pub(crate) fn pressure_point(wrench: &Wrench, z0_mm: f64) -> PressurePoint {
    let (f, m) = (wrench.force_n, wrench.torque_nmm);
    let position_mm = Point2::new((z0_mm * f.x - m.y) / f.z, (m.x + z0_mm * f.y) / f.z);
    let free_moment_nmm = m.z - (position_mm.x * f.y - position_mm.y * f.x);
    PressurePoint { position_mm, free_moment_nmm }
}
