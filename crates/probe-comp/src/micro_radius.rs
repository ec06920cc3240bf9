use crate::ProbeError;

/// Radius of a three-point micro-plane, and what it leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MicroRadius {
    /// Radius ρ of the circle on which the three touches lie.
    pub radius_mm: f64,
    /// Systematic displacement of the contact along the surface.
    pub bias_mm: f64,
    /// Random one, root mean square length.
    pub noise_mm: f64,
}

/// Chooses the radius of a micro-plane of three touches from noise and curvature.
///
/// The balls' centres lie on the part's offset surface, of principal curvatures
/// κ' = κ/(1 − r κ). Three centres 120° apart on a circle of radius ρ are tilted by
/// ρ |κ1' − κ2'|/4 however they are turned, and noise σ tilts them by √(4/3) σ/ρ, so
///
/// ```text
/// bias = r ρ |κ1' − κ2'|/4,   noise = r √(4/3) σ/ρ,   ρ² = 4 √(4/3) σ / |κ1' − κ2'|
/// ```
///
/// `curvatures_per_mm` as [`Nominal::curvatures_per_mm`](crate::Nominal::curvatures_per_mm) gives
/// them, hollow positive. The result stays within `range_mm`.
///
/// # Errors
///
/// [`ProbeError::InvalidOption`]; [`ProbeError::TipTooLarge`] where the ball does not fit the hollow.
pub fn micro_radius(
    tip_radius_mm: f64,
    sigma_mm: f64,
    curvatures_per_mm: [f64; 2],
    range_mm: [f64; 2],
) -> Result<MicroRadius, ProbeError> {
    let positive = |name, value: f64| {
        if value > 0.0 && value.is_finite() {
            Ok(())
        } else {
            let needed = "positive and finite";
            Err(ProbeError::InvalidOption { name, needed, value })
        }
    };
    positive("tip_radius_mm", tip_radius_mm)?;
    positive("sigma_mm", sigma_mm)?;
    positive("range_mm", range_mm[0])?;
    positive("range_mm", range_mm[1] - range_mm[0])?;
    let offset = |curvature: f64| {
        let left = 1.0 - tip_radius_mm * curvature;
        if left > 0.0 {
            return Ok(curvature / left);
        }
        let (radius_mm, hollow_radius_mm) = (tip_radius_mm, curvature.recip());
        Err(ProbeError::TipTooLarge { index: 0, radius_mm, hollow_radius_mm })
    };
    let difference = (offset(curvatures_per_mm[0])? - offset(curvatures_per_mm[1])?).abs();
    let noise = (4.0_f64 / 3.0).sqrt() * sigma_mm;
    let best = (4.0 * noise / difference).sqrt();
    let radius_mm = best.clamp(range_mm[0], range_mm[1]);
    Ok(MicroRadius {
        radius_mm,
        bias_mm: 0.25 * tip_radius_mm * radius_mm * difference,
        noise_mm: tip_radius_mm * noise / radius_mm,
    })
}
