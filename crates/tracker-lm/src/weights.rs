//! Weights of the equations.

use crate::Noise;

/// Standard uncertainties in use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Weights {
    pub(crate) displacement_mm: f64,
    pub(crate) rigid_mm: f64,
}

impl Weights {
    pub(crate) fn new(noise: &Noise, displacement_mm: f64) -> Self {
        Self { displacement_mm, rigid_mm: noise.rigid_mm.unwrap_or(displacement_mm) }
    }
}
