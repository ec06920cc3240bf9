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
        for (effect, amplitude) in at.amplitudes.iter().enumerate() {
            if amplitude[0] != 0.0 {
                for (i, r) in all.iter_mut().enumerate() {
                    *r -= self.effect(effect, amplitude[0], i).0;
                }
            }
        }
        all
    }

    fn base_jacobian(&self, _: &State) -> DMatrix<f64> {
        DMatrix::zeros(self.blocks.len(), 0)
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        let amplitude = at.amplitudes[effect][0];
        DMatrix::from_fn(self.blocks.len(), 1, |i, _| -self.effect(effect, amplitude, i).1)
    }

    fn inside(&self, at: &State) -> Option<Inside> {
        inside(self, at)
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        proposals(self)
    }
}
