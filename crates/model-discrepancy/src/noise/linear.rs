//! A linearised system with the noise models under which it is tested.

use std::ops::Deref;
use std::sync::Arc;

use nalgebra::DVector;

use crate::algebra::linearised::Linearised;
use crate::algebra::system::{Estimate, System};
use crate::noise::noise_models::NoiseModels;

/// Rows that take part in inference; a noise model is worked out when first asked for.
pub(crate) struct Linear<'a> {
    rows: Linearised<'a>,
    pub(crate) noise: Arc<NoiseModels>,
}

impl<'a> Linear<'a> {
    /// Linearises `system` at `at`, on the groups of `keep`, without the `silent` components.
    pub(crate) fn of(system: &System<'a>, at: &Estimate, keep: &[bool], silent: &[bool]) -> Self {
        Self::from(Linearised::of(system, at, keep, silent))
    }

    /// The same rows with the data of a system that differs in nothing else.
    pub(crate) fn with_data(&self, system: &System<'a>, at: &Estimate) -> Self {
        let all = system.residuals(at);
        let whitened = self.rows.rows.iter().zip(&self.sigma).map(|(&row, sigma)| all[row] / sigma);
        let mut residual = DVector::from_iterator(self.sigma.len(), whitened);
        if !system.places().is_empty() {
            // As in a linearisation of its own.
            residual = self.basis.reject(&residual);
        }
        self.with_residual(residual)
    }

    /// The same rows with another whitened residual.
    pub(crate) fn with_residual(&self, residual: DVector<f64>) -> Self {
        let mut rows = self.rows.clone();
        rows.residual = residual;
        Self { rows, noise: Arc::clone(&self.noise) }
    }
}

impl<'a> From<Linearised<'a>> for Linear<'a> {
    fn from(rows: Linearised<'a>) -> Self {
        Self { rows, noise: Arc::default() }
    }
}

impl<'a> Deref for Linear<'a> {
    type Target = Linearised<'a>;

    fn deref(&self) -> &Linearised<'a> {
        &self.rows
    }
}
