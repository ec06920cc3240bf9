//! Factors at the boundary of the coherent set mm, N, N·mm, s, rad.
//!
//! Used where files and parameters are read; everything behind them is already coherent.

/// N·mm in one N·m.
pub const NMM_PER_NM: f64 = 1000.0;

/// mm in one m.
pub const MM_PER_M: f64 = 1000.0;

/// µm in one mm.
pub const UM_PER_MM: f64 = 1000.0;

/// mm in one inch, exact since 1959.
pub const MM_PER_INCH: f64 = 25.4;

/// µrad in one rad.
pub const URAD_PER_RAD: f64 = 1e6;

/// Arc seconds in one rad.
pub const ARCSEC_PER_RAD: f64 = 648_000.0 / std::f64::consts::PI;

/// Standard acceleration of free fall, 3rd CGPM (1901).
pub const STANDARD_GRAVITY_MM_PER_S2: f64 = 9806.65;

/// N in one kg·mm/s²; a mass in kg times an acceleration in mm/s² needs it to be a force in N.
pub const N_PER_KG_MM_PER_S2: f64 = 1e-3;

/// Weight in N of a mass in kg under standard gravity.
///
/// ```
/// assert_eq!(geometry::units::weight_n(2.0), 19.6133);
/// ```
#[must_use]
pub fn weight_n(mass_kg: f64) -> f64 {
    mass_kg * (STANDARD_GRAVITY_MM_PER_S2 * N_PER_KG_MM_PER_S2)
}
