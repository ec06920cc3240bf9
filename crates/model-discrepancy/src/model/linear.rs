//! A model that is linear in everything, as plain matrices.

use nalgebra::{DMatrix, DVector};

use super::{Declared, Inside, Model, Proposal, State};

/// `residual + base·θ + Σ tangentₑ·aₑ`.
#[derive(Clone, Debug)]
pub struct LinearModel {
    /// What is known without computing.
    pub declared: Declared,
    /// Residual where all parameters and amplitudes are zero.
    pub residual: DVector<f64>,
    /// `∂ residual / ∂ base`, `rows × base`.
    pub base: DMatrix<f64>,
    /// One per effect, as [`Model::tangent`].
    pub tangents: Vec<DMatrix<f64>>,
    /// Texts of further measurements, and the model with each.
    pub extended: Vec<(String, LinearModel)>,
}

impl Model for LinearModel {
    fn declared(&self) -> &Declared {
        &self.declared
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        let mut residual = &self.residual + &self.base * &at.base;
        for (effect, amplitudes) in at.amplitudes.iter().enumerate() {
            if amplitudes.iter().any(|a| *a != 0.0) {
                residual.gemv(1.0, &super::whole_tangent(self, at, effect), amplitudes, 1.0);
            }
        }
        residual
    }

    fn base_jacobian(&self, _: &State) -> DMatrix<f64> {
        self.base.clone()
    }

    fn tangent(&self, _: &State, effect: usize) -> DMatrix<f64> {
        self.tangents[effect].clone()
    }

    fn inside(&self, _: &State) -> Option<Inside> {
        None
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        let proposals = self.extended.iter();
        proposals.map(|(text, model)| Proposal::new(text, || Some(model.clone()))).collect()
    }
}
