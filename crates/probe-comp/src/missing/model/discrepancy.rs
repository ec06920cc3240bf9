//! What the loop asks of the model.

use super::ProbeModel;
use crate::missing::proposals;
use crate::missing::term::Term;
use model_discrepancy::{Declared, Inside, Model, Proposal, State};
use nalgebra::{DMatrix, DVector};

impl Model for ProbeModel {
    fn declared(&self) -> &Declared {
        &self.declared
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        let of_touch = |index| {
            let (center, added_mm) = self.corrected(index, at, |_| true);
            self.judged(index, &center, added_mm).map_or(f64::NAN, |(_, deviation_mm)| deviation_mm)
        };
        let of_standard =
            |standard| self.amplitudes_of(standard).map(|(e, k)| at.amplitudes[e][k]).sum();
        let mut residuals = DVector::zeros(self.declared.layout.rows.len());
        let touches = (0..self.touches.len()).map(of_touch);
        let all = touches.chain(self.standards.iter().map(of_standard));
        residuals.iter_mut().zip(all).for_each(|(residual, value)| *residual = value);
        residuals += self.by_base() * &at.base;
        residuals
    }

    fn base_jacobian(&self, _: &State) -> DMatrix<f64> {
        self.by_base()
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        if matches!(self.terms[effect], Term::BadPoint { .. }) {
            return DMatrix::from_element(1, 1, -1.0);
        }
        let rows = self.declared.layout.rows.len();
        let mut tangent = DMatrix::zeros(rows, self.declared.effects[effect].parameters.len());
        for index in 0..self.touches.len() {
            for (k, value) in self.row(at, effect, index).into_iter().enumerate() {
                tangent[(index, k)] = value;
            }
        }
        for (k, standard) in self.standards.iter().enumerate() {
            for (_, column) in self.amplitudes_of(standard).filter(|(e, _)| *e == effect) {
                tangent[(self.touches.len() + k, column)] = 1.0;
            }
        }
        tangent
    }

    fn inside(&self, _: &State) -> Option<Inside> {
        None
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        proposals::proposals(self)
    }
}
