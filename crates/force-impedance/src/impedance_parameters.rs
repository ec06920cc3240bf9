/// kg to N·s²/mm.
const N_S2_PER_MM_PER_KG: f64 = 1e-3;

/// How the contact is to feel: `M·E'' + D·E' + K·E = F_n − F_r`.
///
/// `E` is the correction along the outward normal, so that a force above the reference moves
/// the tool away.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ImpedanceParameters {
    /// `M`, positive.
    pub mass_kg: f64,
    /// `D`, positive.
    pub damping_ns_per_mm: f64,
    /// `K`, zero or more; with offsets counted from the programmed path the force is constant
    /// only where it is zero.
    pub stiffness_n_per_mm: f64,
}

impl ImpedanceParameters {
    pub(crate) fn mass_ns2_per_mm(&self) -> f64 {
        self.mass_kg * N_S2_PER_MM_PER_KG
    }
}
