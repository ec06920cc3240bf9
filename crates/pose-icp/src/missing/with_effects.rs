//! The pose with accepted effects in the model, its uncertainty, and where the machine reads a point.

use model_discrepancy::{Column, State};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix4, Matrix6, Point3, Vector3};

use super::model::PoseModel;
use super::term::Term;
use crate::PoseStart;

impl PoseModel {
    /// The pose at the parameters of a state.
    #[must_use]
    pub fn pose_at(&self, at: &State) -> PoseStart {
        self.chart(0, at).pose()
    }

    /// Covariance of `[x y z α β γ]`: mm², mm·rad, rad².
    ///
    /// `covariance` is that of `columns`; a held parameter moves where an effect says that it is
    /// wrong.
    #[must_use]
    pub fn pose_covariance(
        &self,
        at: &State,
        columns: &[Column],
        covariance: &DMatrix<f64>,
    ) -> Matrix6<f64> {
        let along = self.pose_by_columns(at, columns);
        let spread = &along * covariance * along.transpose();
        Matrix6::from_iterator(spread.iter().copied())
    }

    /// `∂ [x y z α β γ] / ∂ columns`.
    pub(super) fn pose_by_columns(&self, at: &State, columns: &[Column]) -> DMatrix<f64> {
        let to_pose = self.chart(0, at).pose_jacobian();
        let mut along = DMatrix::zeros(6, columns.len());
        for (k, column) in columns.iter().enumerate() {
            let moved = match *column {
                Column::Base(index) => self.free.get(index).copied(),
                Column::Amplitude { effect, parameter } => match &self.terms[effect] {
                    Term::Pose(parameters) => parameters.get(parameter).copied(),
                    _ => None,
                },
                Column::Empirical { .. } | Column::Place { .. } => None,
            };
            if let Some(moved) = moved {
                along.column_mut(k).copy_from(&to_pose.column(moved));
            }
        }
        along
    }

    /// Place where the machine reads right although its axes are long or out of square: the mean of
    /// all readings.
    #[must_use]
    pub fn reference_mm(&self) -> Point3<f64> {
        Point3::from(self.center_mm)
    }

    /// Whether an effect that refers to [`PoseModel::reference_mm`] is in the model.
    #[must_use]
    pub fn has_reference(&self, at: &State) -> bool {
        self.machine_errors(at) != Matrix3::zeros()
    }

    /// Takes a point of the workpiece to where the machine reads it: the pose, and what the axes
    /// add to a reading, `reading = c + (1 − E)⁻¹ (pose·point − c)` with scales on the diagonal
    /// of E, squarenesses beside it, and c the reference.
    ///
    /// A drift counts from the first touch, a growth with temperature from 20 °C.
    #[must_use]
    pub fn reading_from_workpiece(&self, at: &State) -> Matrix4<f64> {
        let pose = self.pose_at(at).machine_from_workpiece();
        let sound = self.sound(at);
        // Errors beyond 100 % leave no reading; the loop does not accept what makes them.
        let reads = sound.try_inverse().unwrap_or_else(Matrix3::identity);
        let linear = reads * pose.rotation.to_rotation_matrix().into_inner();
        let center = self.center_mm;
        let at_origin = center + reads * (pose.translation.vector - center);
        let mut matrix = Matrix4::identity();
        matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&linear);
        matrix.fixed_view_mut::<3, 1>(0, 3).copy_from(&at_origin);
        matrix
    }

    /// What the axes add to a reading, per distance from the reference.
    pub(super) fn machine_errors(&self, at: &State) -> Matrix3<f64> {
        let of_term = |(term, amplitudes): (&Term, &DVector<f64>)| {
            let units = term.of_distance().into_iter();
            units.zip(amplitudes).map(|(adds, a)| adds * *a).sum::<Matrix3<f64>>()
        };
        self.terms.iter().zip(&at.amplitudes).map(of_term).sum()
    }

    /// Contact and normal of a touch on the part where it is declared to lie, workpiece frame:
    /// where the errors of form are taken.
    #[must_use]
    pub fn declared_contact(&self, index: usize) -> (Point3<f64>, Vector3<f64>) {
        let foot = &self.contacts[index];
        (foot.point_mm, foot.normal.into_inner())
    }
}
