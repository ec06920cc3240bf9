//! What the loop asks of the model.

use super::TrackerModel;
use model_discrepancy::{Declared, Inside, Model, Proposal, State};
use nalgebra::{DMatrix, DVector};

impl Model for TrackerModel {
    fn declared(&self) -> &Declared {
        &self.linear.declared
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        self.linear.residuals(at)
    }

    fn base_jacobian(&self, at: &State) -> DMatrix<f64> {
        self.linear.base_jacobian(at)
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        self.linear.tangent(at, effect)
    }

    fn inside(&self, _: &State) -> Option<Inside> {
        None
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        crate::missing::proposals::proposals(self)
    }
}
