use std::fmt;

use probe_comp::{MicroRadius, ProbeError, micro_radius};
use serde::Serialize;

use crate::Header;

/// What the radius of a micro-plane is chosen from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MicroPlaneInput {
    /// Radius of the ball.
    pub tip_radius_mm: f64,
    /// Standard uncertainty of a touch along the normal.
    pub noise_mm: f64,
    /// Principal curvatures of the part, hollow positive.
    pub curvatures_per_mm: [f64; 2],
    /// Smallest and largest radius that the machine can go to.
    pub range_mm: [f64; 2],
}

/// Radius of the circle of three touches of \[E\]; serialises as its JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MicroPlane {
    /// Form and program.
    #[serde(flatten)]
    pub header: Header,
    /// ρ.
    pub radius_mm: f64,
    /// Systematic displacement of the contact along the surface, r ρ |κ1' − κ2'|/4.
    pub bias_mm: f64,
    /// Random one, root mean square length.
    pub noise_mm: f64,
}

/// The radius at which what three touches on a circle miss by curvature and by noise is balanced.
///
/// # Errors
///
/// As [`micro_radius`].
pub fn design_micro_plane(input: &MicroPlaneInput) -> Result<MicroPlane, ProbeError> {
    let MicroPlaneInput { tip_radius_mm, noise_mm, curvatures_per_mm, range_mm } = *input;
    let MicroRadius { radius_mm, bias_mm, noise_mm } =
        micro_radius(tip_radius_mm, noise_mm, curvatures_per_mm, range_mm)?;
    let header = Header::without_case("truing/design-micro-plane/1", Vec::new());
    Ok(MicroPlane { header, radius_mm, bias_mm, noise_mm })
}

impl fmt::Display for MicroPlane {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "radius of the three touches: {:.3} mm", self.radius_mm)?;
        writeln!(
            f,
            "the contact is found {:.1} µm off along the surface by curvature, {:.1} µm rms by noise",
            1e3 * self.bias_mm,
            1e3 * self.noise_mm
        )
    }
}
