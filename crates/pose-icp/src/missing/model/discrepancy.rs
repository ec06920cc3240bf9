//! What the loop asks of the model.

use super::PoseModel;
use crate::missing::proposals;
use crate::missing::term::{Term, stacked};
use model_discrepancy::{Declared, Inside, Model, Proposal, State};
use nalgebra::{DMatrix, DVector, Vector3};

impl Model for PoseModel {
    fn declared(&self) -> &Declared {
        &self.declared
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        let charts = self.charts(at);
        let target_mm = self.options.tip.signed_radius_mm();
        let sound = self.sound(at);
        let mut residuals = Vec::with_capacity(self.declared.layout.rows.len());
        for (index, &setup) in self.setup_of.iter().enumerate() {
            let (center_mm, added_mm) = self.corrected(index, at);
            let distance_mm = self
                .foot(&charts[setup], &center_mm)
                .map_or(f64::NAN, |foot| foot.signed_distance_mm);
            let (_, length) = self.read_along(index, &charts[setup], &sound);
            residuals.push((distance_mm - target_mm - added_mm) / length);
        }
        for (setup, chart) in self.setups.iter().zip(&charts) {
            if let Some(lateral) = &setup.lateral {
                residuals.extend(lateral.equations(chart).map(|(_, residual)| residual));
            }
        }
        for standard in &self.standards {
            let of = |(e, k): (usize, usize)| at.amplitudes[e][k];
            residuals.push(self.amplitude_of(standard).map_or(0.0, of));
        }
        DVector::from_vec(residuals)
    }

    fn base_jacobian(&self, at: &State) -> DMatrix<f64> {
        let mut jacobian =
            DMatrix::zeros(self.declared.layout.rows.len(), self.declared.base.len());
        for (i, (setup, row)) in self.pose_rows(at).into_iter().enumerate() {
            for (k, &parameter) in self.free.iter().enumerate() {
                jacobian[(i, self.setups[setup].first + k)] = row[parameter];
            }
        }
        jacobian
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        let term = &self.terms[effect];
        let sound = self.sound(at);
        if let Term::BadPoint { observation } = *term {
            let chart = self.chart(self.setup_of[observation], at);
            let (_, length) = self.read_along(observation, &chart, &sound);
            return DMatrix::from_element(1, 1, -1.0 / length);
        }
        let (rows, columns) =
            (self.declared.layout.rows.len(), self.declared.effects[effect].parameters.len());
        if let Term::Pose(parameters) = term {
            let pose_rows = self.pose_rows(at);
            return DMatrix::from_fn(rows, columns, |i, k| {
                pose_rows.get(i).map_or(0.0, |(_, row)| row[parameters[k]])
            });
        }
        let charts = self.charts(at);
        let parts = self.distances();
        let target_mm = self.options.tip.signed_radius_mm();
        let of_distance = term.of_distance();
        let of_touch = |i: usize| -> Vec<f64> {
            let contact = self.contact(i);
            let readings = term.readings(&contact);
            let mut values = vec![0.0; columns];
            let chart = &charts[self.setup_of[i]];
            let (weights, length) = self.read_along(i, chart, &sound);
            if !readings.is_empty() {
                let (center_mm, added_mm) = self.corrected(i, at);
                let (normal, distance_mm) = self.foot(chart, &center_mm).map_or_else(
                    || (Vector3::repeat(f64::NAN), f64::NAN),
                    |foot| (chart.direction_to_machine(&foot.normal), foot.signed_distance_mm),
                );
                for (value, reading) in values.iter_mut().zip(&readings) {
                    *value -= normal.dot(reading);
                }
                let beyond_mm = distance_mm - target_mm - added_mm;
                for (value, adds) in values.iter_mut().zip(&of_distance) {
                    let longer = weights.dot(&adds.tr_mul(&normal)) / length.powi(2);
                    *value += beyond_mm * longer;
                }
            }
            for (value, distance) in values.iter_mut().zip(term.distances(&contact, &parts)) {
                *value -= distance;
            }
            values.iter().map(|value| value / length).collect()
        };
        let mut tangent = stacked(rows, columns, of_touch, self.touches.len());
        for (k, standard) in self.standards.iter().enumerate() {
            if let Some((_, column)) = self.amplitude_of(standard).filter(|(e, _)| *e == effect) {
                tangent[(rows - self.standards.len() + k, column)] = 1.0;
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
