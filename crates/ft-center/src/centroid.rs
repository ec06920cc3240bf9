//! Force centre and removal centre of a pad under uneven pressure.

use nalgebra::Vector2;

use crate::FtCenterError;
use crate::error::require_positive;

/// Where the force sensor sees the pad, from the pad's axis: `g a²/4`.
///
/// The pressure over a round pad of radius `a` is `p₀ (1 + g·x)`, `x` from the pad's axis; its
/// first moment over its integral is the centre of pressure. `g` is the relative gradient: 0.01
/// /mm raises the pressure by 1 % of its mean per mm.
///
/// # Errors
///
/// [`FtCenterError::PadLiftsOff`] when `|g| a > 1` (the pressure would be negative at the rim),
/// [`FtCenterError::NotPositive`] for the radius, [`FtCenterError::NotFinite`].
pub fn pressure_centroid_mm(
    gradient_per_mm: Vector2<f64>,
    pad_radius_mm: f64,
) -> Result<Vector2<f64>, FtCenterError> {
    check(&gradient_per_mm, pad_radius_mm)?;
    Ok(gradient_per_mm * (0.25 * pad_radius_mm * pad_radius_mm))
}

/// Where the pad removes material, from the pad's axis: `0.3 g a²`.
///
/// Preston's law, removal `∝ p·v`, with the pressure of [`pressure_centroid_mm`] and the speed
/// `v = ω r` of a pad that spins about its own axis much faster than it is fed. The rim removes
/// more than it presses, so the removal centre lies 20 % farther out than the force centre.
///
/// # Errors
///
/// As [`pressure_centroid_mm`].
pub fn removal_centroid_mm(
    gradient_per_mm: Vector2<f64>,
    pad_radius_mm: f64,
) -> Result<Vector2<f64>, FtCenterError> {
    check(&gradient_per_mm, pad_radius_mm)?;
    Ok(gradient_per_mm * (0.3 * pad_radius_mm * pad_radius_mm))
}

fn check(gradient_per_mm: &Vector2<f64>, pad_radius_mm: f64) -> Result<(), FtCenterError> {
    require_positive(pad_radius_mm, "pad_radius_mm")?;
    let gradient = gradient_per_mm.norm();
    if !gradient.is_finite() {
        return Err(FtCenterError::NotFinite { index: 0 });
    }
    // The rim belongs to the pad, whatever round-off does to the product.
    if gradient * pad_radius_mm > 1.0 + 4.0 * f64::EPSILON {
        let radius_mm = pad_radius_mm;
        return Err(FtCenterError::PadLiftsOff { gradient_per_mm: gradient, radius_mm });
    }
    Ok(())
}
