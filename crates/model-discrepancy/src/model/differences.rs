//! Derivatives by central differences, for models of which only the residual is written down.

use nalgebra::{DMatrix, DVector};

use super::{Declared, Inside, Model, Parameter, Proposal, Scope, State};

/// Relative step of the central difference: the cube root of the machine epsilon balances
/// truncation and round-off.
const STEP: f64 = 6e-6;

/// A model given by its residual alone.
///
/// Derivatives cost two residuals per parameter, and are good to about 1e-9 of a column's longest
/// entry. Write them down where that is too slow, and let
/// [`check_tangents`](crate::check_tangents) compare them.
#[derive(Clone, Debug)]
pub struct Differenced<F> {
    /// What is known without computing.
    pub declared: Declared,
    /// Residuals, one per row.
    pub residuals: F,
}

impl<F: Fn(&State) -> DVector<f64> + Sync> Model for Differenced<F> {
    fn declared(&self) -> &Declared {
        &self.declared
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        (self.residuals)(at)
    }

    fn base_jacobian(&self, at: &State) -> DMatrix<f64> {
        let columns = self
            .declared
            .base
            .iter()
            .enumerate()
            .map(|(i, parameter)| derivative(self, at, parameter, |at| &mut at.base[i]));
        stacked(self, columns)
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        let Declared { layout, effects, .. } = &self.declared;
        let columns = effects[effect].parameters.iter().enumerate().map(|(i, parameter)| {
            derivative(self, at, parameter, |at| &mut at.amplitudes[effect][i])
        });
        let whole = stacked(self, columns);
        let Scope::Observation(observation) = effects[effect].scope else { return whole };
        let own: Vec<usize> = (0..layout.rows.len())
            .filter(|&row| layout.rows[row].observation == observation)
            .collect();
        whole.select_rows(&own)
    }

    fn inside(&self, _: &State) -> Option<Inside> {
        None
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        Vec::new()
    }
}

fn stacked(model: &dyn Model, columns: impl Iterator<Item = DVector<f64>>) -> DMatrix<f64> {
    let columns: Vec<_> = columns.collect();
    let rows = model.declared().layout.rows.len();
    if columns.is_empty() { DMatrix::zeros(rows, 0) } else { DMatrix::from_columns(&columns) }
}

/// A scale of a parameter is what it is reported in; how strongly it acts there says the rest.
fn derivative(
    model: &dyn Model,
    at: &State,
    parameter: &Parameter,
    of: impl Fn(&mut State) -> &mut f64,
) -> DVector<f64> {
    let unit = 1.0 / parameter.report_factor.abs();
    let rough = difference(model, at, &of, if unit.is_finite() { unit } else { 1.0 });
    let natural = natural_step(model, at, &rough);
    if natural > 0.0 { difference(model, at, &of, natural) } else { rough }
}

/// Change of a parameter that moves the longest residual by its own length, or by one unit.
pub(super) fn natural_step(model: &dyn Model, at: &State, column: &DVector<f64>) -> f64 {
    let size = column.amax();
    if size > 0.0 { model.residuals(at).amax().max(1.0) / size } else { 0.0 }
}

/// Central difference by the parameter that `of` picks; `natural` is a change that matters.
pub(super) fn difference(
    model: &dyn Model,
    at: &State,
    of: &impl Fn(&mut State) -> &mut f64,
    natural: f64,
) -> DVector<f64> {
    let mut moved = at.clone();
    let value = *of(&mut moved);
    let step = STEP * natural.max(value.abs());
    let mut at_step = |by: f64| {
        *of(&mut moved) = value + by;
        model.residuals(&moved)
    };
    (at_step(step) - at_step(-step)) / (2.0 * step)
}
