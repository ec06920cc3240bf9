//! Contacts with accepted effects in the model, and their uncertainty.

use model_discrepancy::{Closure, Column, Role, State};
use nalgebra::{DMatrix, Matrix3, RowDVector, Vector3};

use super::model::ProbeModel;
use super::term::Term;

/// What accepted effects change in a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactChange {
    /// Displacement of the contact.
    pub moved_mm: Vector3<f64>,
    /// How far the contact is above the nominal surface, along its normal.
    pub deviation_mm: f64,
    /// Standard uncertainty of the deviation; `None` where an effect of this touch alone leaves
    /// nothing of its reading.
    pub sigma_deviation_mm: Option<f64>,
    /// Standard uncertainty along the surface, root mean square over both ways.
    pub sigma_tangential_mm: f64,
}

/// Share of its own variance that a touch keeps at least: below it, an effect of its own has taken
/// up the whole reading, and its deviation says nothing.
const KEPT_SHARE: f64 = 1e-6;

impl ProbeModel {
    /// A contact without what the accepted effects added to it; errors of the part's own form, and
    /// what follows a covariate without a known cause, stay in.
    ///
    /// `sigmas_mm` are the standard uncertainties of the declared contact along the normal and along
    /// the surface, by the noise of this touch. `None` where the corrected ball has no foot.
    #[must_use]
    pub fn contact_change(
        &self,
        index: usize,
        closure: &Closure,
        sigmas_mm: [f64; 2],
    ) -> Option<ContactChange> {
        let nothing = State::declared(closure.state.base.clone(), &self.declared.effects);
        let (declared_mm, ..) = self.contact_at(index, &nothing)?;
        let (point_mm, normal, deviation_mm) = self.contact_at(index, &closure.state)?;
        let covariance = &closure.covariance;
        let is_of_touch = |effect: usize| matches!(self.terms[effect], Term::BadPoint { observation } if observation == index);
        let all = closure.jacobian.row(index);
        let mut by_effects: RowDVector<f64> = all.into_owned();
        for (value, column) in by_effects.iter_mut().zip(&closure.columns) {
            match *column {
                Column::Amplitude { effect, .. } if !self.terms[effect].is_of_the_part() => {}
                _ => *value = 0.0,
            }
        }
        // A fitted touch has part in the amplitudes that correct it: with them its own noise shrinks.
        let noise = closure.variance_factor * sigmas_mm[0].powi(2);
        let follows = (&by_effects * covariance * by_effects.transpose())[0];
        let shared = if self.touches[index].role == Role::Fit {
            (&by_effects * covariance * all.transpose())[0]
        } else {
            0.0
        };
        let variance = noise + follows - 2.0 * shared;
        let alone = closure.columns.iter().any(
            |column| matches!(*column, Column::Amplitude { effect, .. } if is_of_touch(effect)),
        );
        let is_known = !alone && variance > KEPT_SHARE * noise;
        let tangential = closure.variance_factor * sigmas_mm[1].powi(2)
            + self.tangential_variance(index, closure, &normal.into_inner());
        Some(ContactChange {
            moved_mm: point_mm - declared_mm,
            deviation_mm,
            sigma_deviation_mm: is_known.then(|| variance.sqrt()),
            sigma_tangential_mm: tangential.max(0.0).sqrt(),
        })
    }

    /// What the amplitudes' uncertainty does to the ball's centre along the surface, mean square of
    /// both ways.
    fn tangential_variance(&self, index: usize, closure: &Closure, normal: &Vector3<f64>) -> f64 {
        let zero = self.azimuth_zero(index);
        let situation = self.situation(index, &zero);
        let mut by_columns = DMatrix::zeros(3, closure.columns.len());
        for (k, column) in closure.columns.iter().enumerate() {
            if let Column::Amplitude { effect, parameter } = *column
                && let Some(reading) = self.terms[effect].readings(&situation).get(parameter)
            {
                by_columns.column_mut(k).copy_from(reading);
            }
        }
        let spread = &by_columns * &closure.covariance * by_columns.transpose();
        let spread = Matrix3::from_iterator(spread.iter().copied());
        0.5 * (spread.trace() - normal.dot(&(spread * normal)))
    }
}
