use nalgebra::Vector2;

use crate::ProbeError;

/// A contact of a ball that was scanned along a profile, in the plane of x and z.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ProfileContact {
    /// Ball's centre, (x, z).
    pub center_mm: Vector2<f64>,
    /// Contact, (x, z).
    pub point_mm: Vector2<f64>,
    /// Inclination of the normal towards +x, θ.
    pub inclination_rad: f64,
    /// Standard uncertainty of it, from that of the two neighbours.
    pub sigma_inclination_rad: f64,
}

/// Contacts of a ball on a profile z(x), by the neighbours of each place (document \[E\], 2-D).
///
/// With ball centres z₁ and z₂ at x ∓ h, tan θ' = (z₁ − z₂)/(2h) and
/// A' = (x − r sin θ', z − r cos θ'). The first and the last place have no second neighbour and
/// no contact: `centers_mm` of n places give n − 2. Places may be unevenly apart; the slope is
/// then that of the parabola through the three. `sigma_mm` is the standard uncertainty of a z.
///
/// # Errors
///
/// [`ProbeError::InvalidProfile`], [`ProbeError::InvalidTip`].
pub fn compensate_profile(
    centers_mm: &[Vector2<f64>],
    tip_radius_mm: f64,
    sigma_mm: f64,
) -> Result<Vec<ProfileContact>, ProbeError> {
    if !(tip_radius_mm >= 0.0 && tip_radius_mm.is_finite()) {
        return Err(ProbeError::InvalidTip { radius_mm: tip_radius_mm });
    }
    let increases = |w: &[Vector2<f64>]| w[0].x < w[1].x && w.iter().all(|p| p.y.is_finite());
    if centers_mm.len() < 3 || !centers_mm.windows(2).all(increases) {
        return Err(ProbeError::InvalidProfile { got: centers_mm.len() });
    }
    let contact = |w: &[Vector2<f64>]| {
        let [before, at, after] = [w[0], w[1], w[2]];
        let (left, right) = (at.x - before.x, after.x - at.x);
        // Weights of the three heights in the parabola's slope; −1/2h, 0, 1/2h for even steps.
        let span = left + right;
        let weights =
            [-right / (left * span), (right - left) / (left * right), left / (right * span)];
        let slope = weights[0] * before.y + weights[1] * at.y + weights[2] * after.y;
        let inclination_rad = (-slope).atan();
        let (sin, cos) = inclination_rad.sin_cos();
        let gain = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
        ProfileContact {
            center_mm: at,
            point_mm: at - Vector2::new(sin, cos) * tip_radius_mm,
            inclination_rad,
            sigma_inclination_rad: sigma_mm * gain * cos * cos,
        }
    };
    Ok(centers_mm.windows(3).map(contact).collect())
}
