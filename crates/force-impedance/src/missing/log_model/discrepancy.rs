//! What the loop asks of the model.

use super::LogModel;
use crate::missing::log_inside::inside;
use crate::missing::log_proposals::proposals;
use model_discrepancy::{Declared, Inside, Model, Proposal, State};
use nalgebra::{DMatrix, DVector};

impl Model for LogModel {
    fn declared(&self) -> &Declared {
        &self.declared
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        let mut all =
            DVector::from_iterator(self.blocks.len(), self.blocks.iter().map(|b| b.residual));
        for (effect, amplitudes) in at.amplitudes.iter().enumerate() {
            let amplitudes = amplitudes.as_slice();
            if at.has(effect) {
                for (i, r) in all.iter_mut().enumerate() {
                    *r -= self.effect(effect, amplitudes, i).0;
                }
            }
        }
        all
    }

    fn base_jacobian(&self, _: &State) -> DMatrix<f64> {
        DMatrix::zeros(self.blocks.len(), 0)
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        let amplitudes = at.amplitudes[effect].as_slice();
        let of_block = |i: usize, k: usize| -self.effect(effect, amplitudes, i).1[k];
        DMatrix::from_fn(self.blocks.len(), amplitudes.len(), of_block)
    }

    fn inside(&self, at: &State) -> Option<Inside> {
        inside(self, at)
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        proposals(self)
    }
}
