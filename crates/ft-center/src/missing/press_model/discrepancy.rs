//! What the loop asks of the model.

use super::PressModel;
use crate::missing::press_proposals::proposals;
use model_discrepancy::{Declared, Inside, Model, Proposal, State};
use nalgebra::{DMatrix, DVector};

impl Model for PressModel {
    fn declared(&self) -> &Declared {
        &self.declared
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        let unpacked = self.design.unpack(at);
        let mut rows = Vec::with_capacity(self.declared.layout.rows.len());
        for point in &self.points {
            rows.extend(self.design.residual(point, &unpacked, at).iter());
        }
        for standard in &self.standards {
            rows.extend(self.design.standard_residual(*standard, &unpacked));
        }
        DVector::from_vec(rows)
    }

    fn base_jacobian(&self, at: &State) -> DMatrix<f64> {
        let unpacked = self.design.unpack(at);
        let mut jacobian = DMatrix::zeros(self.declared.layout.rows.len(), 3);
        for (i, point) in self.points.iter().enumerate() {
            let block = self.design.base_jacobian(point, &unpacked);
            jacobian.fixed_view_mut::<2, 3>(2 * i, 0).copy_from(&block);
        }
        let mut row = 2 * self.points.len();
        for standard in &self.standards {
            let block = self.design.standard_base_jacobian(*standard, &unpacked);
            jacobian.rows_mut(row, block.nrows()).copy_from(&block);
            row += block.nrows();
        }
        jacobian
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        let unpacked = self.design.unpack(at);
        let parameters = self.declared.effects[effect].parameters.len();
        let mut tangent = DMatrix::zeros(self.declared.layout.rows.len(), parameters);
        for (i, point) in self.points.iter().enumerate() {
            let block = self.design.tangent(point, &unpacked, effect);
            tangent.rows_mut(2 * i, 2).copy_from(&block);
        }
        let mut row = 2 * self.points.len();
        for standard in &self.standards {
            let block = self.design.standard_tangent(*standard, &unpacked, effect, parameters);
            tangent.rows_mut(row, block.nrows()).copy_from(&block);
            row += block.nrows();
        }
        tangent
    }

    fn inside(&self, _: &State) -> Option<Inside> {
        None
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        proposals(self)
    }
}
