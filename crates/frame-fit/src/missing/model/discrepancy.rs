//! What the loop asks of the model.

use super::{FrameModel, displacement};
use crate::decompose::dynamic;
use crate::missing::finite_motion::derivatives;
use crate::missing::proposals;
use crate::missing::term::{self, Place, Term};
use model_discrepancy::{Declared, Inside, Model, Proposal, State};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

impl<const D: usize> Model for FrameModel<D> {
    fn declared(&self) -> &Declared {
        &self.declared
    }

    /// Everything is a displacement from the images under `reference`, so that residuals of
    /// micrometres keep their digits far from the origin.
    fn residuals(&self, at: &State) -> DVector<f64> {
        let moved = self.moved_at(&at.base);
        let (rotation, rotation_pivot_mm) = self.target_rotation(at);
        let after = self.active(at, Place::Target);
        let mut residuals = DVector::zeros(D * self.points.len());
        for (i, deformation) in self.deformations(at).into_iter().enumerate() {
            let image_mm = self.images_mm[i];
            let mapped =
                deformation + moved.displacement(&(image_mm + deformation - self.pivot_mm));
            let turned = mapped + rotation * (image_mm + mapped - rotation_pivot_mm);
            let total = turned + displacement(&after, i, &(image_mm + turned));
            let missed = self.points[i].pair.target_mm.coords - image_mm;
            residuals.fixed_rows_mut::<D>(D * i).copy_from(&(missed - total));
        }
        residuals
    }

    fn base_jacobian(&self, at: &State) -> DMatrix<f64> {
        let (rotation, _) = self.target_rotation(at);
        let turned = SMatrix::<f64, D, D>::identity() + rotation;
        let deformed = self.images_mm.iter().zip(self.deformations(at));
        let arms_mm: Vec<SVector<f64, D>> = deformed
            .map(|(image_mm, deformation)| image_mm + deformation - self.pivot_mm)
            .collect();
        let mut jacobian = DMatrix::zeros(D * arms_mm.len(), self.motions.len());
        let derivatives = derivatives::<D>(self.transform, &self.motions, &at.base);
        for (mut column, derivative) in jacobian.column_iter_mut().zip(derivatives) {
            let derivative = derivative.turned(&-turned);
            for (i, arm_mm) in arms_mm.iter().enumerate() {
                column.fixed_rows_mut::<D>(D * i).copy_from(&derivative.displacement(arm_mm));
            }
        }
        jacobian
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        let term = &self.terms[effect];
        if matches!(term, Term::BadPoint { .. }) {
            // Adds to the target, last of all.
            return -DMatrix::identity(D, D);
        }
        let amplitude = &at.amplitudes[effect];
        let moved = self.moved_at(&at.base);
        let (rotation, rotation_pivot_mm) = self.target_rotation(at);
        let turned = SMatrix::identity() + rotation;
        if term.place() == Place::Rotation {
            let deformations = self.deformations(at);
            return self.stacked(amplitude.len(), |i| {
                let deformed = self.images_mm[i] + deformations[i];
                let mapped = deformed + moved.displacement(&(deformed - self.pivot_mm));
                Some(-term::rotation_columns(amplitude, &(turned * (mapped - rotation_pivot_mm))))
            });
        }
        let carried = match term.place() {
            Place::Source => turned * (SMatrix::identity() + moved.strain) * self.reference.linear,
            _ => SMatrix::identity(),
        };
        let carried = dynamic(&-carried);
        self.stacked(amplitude.len(), |i| {
            let source_mm = self.points[i].pair.source_mm.coords;
            term.touches(i).then(|| &carried * term.columns(i, &source_mm))
        })
    }

    fn inside(&self, _: &State) -> Option<Inside> {
        None
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        proposals::proposals(self)
    }
}
