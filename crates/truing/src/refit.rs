//! The model that a loop ended with, fitted to other data of the same case.

use std::ops::Range;
use std::sync::Arc;

use least_squares::{Options, Problem, solve};
use model_discrepancy::{Closure, Column, Effect, Model, Parameter, Role, State, whole_tangent};
use nalgebra::{DMatrix, DVector, Matrix};

use crate::estimates::Estimates;
use crate::measured::Prepared;
use crate::settled::MOST_ROUNDS;
use crate::{Case, Error};

/// Effects that a loop accepted, by what they are called.
#[derive(Debug)]
pub(crate) struct Accepted<'c> {
    closure: &'c Closure,
    amplitudes: Vec<Amplitude>,
}

/// One free amplitude of an accepted effect.
#[derive(Clone, Debug)]
pub(crate) struct Amplitude {
    /// Its effect, with the subject, and its own name.
    pub(crate) name: String,
    /// Unit of value and uncertainty.
    pub(crate) unit: String,
    /// As found.
    pub(crate) value: f64,
    /// Standard uncertainty by linear propagation.
    pub(crate) std: f64,
    effect: (String, Option<String>),
    parameter: usize,
    /// Reported value = internal value × factor.
    factor: f64,
}

/// What the model is in other data.
pub(crate) struct Refitted {
    pub(crate) estimates: Arc<dyn Estimates>,
    /// In the order of [`Accepted::amplitudes`] and in their units.
    pub(crate) amplitudes: Vec<f64>,
}

impl<'c> Accepted<'c> {
    /// Of a closure on the model that `case` has.
    pub(crate) fn of(case: &Case, closure: &'c Closure) -> Result<Self, Error> {
        let (prepared, _) = case.prepare()?;
        let effects = &prepared.model.declared().effects;
        let named = |(k, column): (usize, &Column)| {
            let Column::Amplitude { effect, parameter } = *column else { return None };
            let value = closure.state.amplitudes[effect][parameter];
            let variance = closure.covariance[(k, k)].max(0.0);
            let Effect { id, subject, parameters, .. } = &effects[effect];
            let Parameter { name, unit, report_factor: factor } = &parameters[parameter];
            let of = subject.as_ref().map_or_else(|| id.clone(), |about| format!("{id} [{about}]"));
            Some(Amplitude {
                name: format!("{of}: {name}"),
                unit: unit.clone(),
                value: factor * value,
                std: factor.abs() * variance.sqrt(),
                effect: (id.clone(), subject.clone()),
                parameter,
                factor: *factor,
            })
        };
        let amplitudes = closure.columns.iter().enumerate().filter_map(named).collect();
        Ok(Self { closure, amplitudes })
    }

    /// Every free amplitude of every accepted effect.
    pub(crate) fn amplitudes(&self) -> &[Amplitude] {
        &self.amplitudes
    }

    /// Fits them to the data of `case`; `None` where these give no solution, or have no such effect.
    ///
    /// What was chosen stays chosen, and an effect that was found at a place stays there.
    pub(crate) fn fitted_to(&self, case: &Case) -> Result<Option<Refitted>, Error> {
        let (mut prepared, _) = case.prepare()?;
        for round in 0..=MOST_ROUNDS {
            let Some((closure, amplitudes)) = self.fitted(&prepared) else { return Ok(None) };
            match prepared.there(&closure.solution())? {
                Some(there) if round < MOST_ROUNDS => prepared = there,
                _ => {
                    let estimates = (prepared.estimates)(&closure);
                    return Ok(Some(Refitted { estimates, amplitudes }));
                }
            }
        }
        Ok(None)
    }

    fn fitted(&self, prepared: &Prepared<'_>) -> Option<(Closure, Vec<f64>)> {
        let model = &*prepared.model;
        let free = Free::of(self, model)?;
        let start = free.start(self);
        let point = solve(&free, start, &Options::default()).ok()?.point;
        let state = free.state(&point);
        let residuals_after = free.residuals_of_all(&point).iter().copied().collect();
        let mut empirical = self.closure.empirical.clone();
        let mut coefficients = point.iter().skip(free.empirical().start).copied();
        for correction in &mut empirical {
            correction.coefficients.iter_mut().for_each(|c| *c = coefficients.next().unwrap_or(*c));
        }
        let amplitudes = self.amplitudes.iter().zip(&point.as_slice()[free.amplitudes()]);
        let amplitudes = amplitudes.map(|(a, value)| a.factor * value).collect();
        let columns = free.columns(&self.closure.columns);
        let closure =
            Closure { state, columns, residuals_after, empirical, ..self.closure.clone() };
        Some((closure, amplitudes))
    }
}

/// Base parameters, accepted amplitudes and empirical coefficients, one after the other.
struct Free<'m> {
    model: &'m dyn Model,
    /// Effect and place among its amplitudes.
    amplitudes: Vec<(usize, usize)>,
    /// What one unit of each empirical coefficient adds to every row.
    added: DMatrix<f64>,
    /// Rows that are fitted.
    rows: Vec<usize>,
}

impl<'m> Free<'m> {
    /// The columns of a closure as this model counts its effects: other data may show a course or a
    /// patch of their own beside them.
    fn columns(&self, of_closure: &[Column]) -> Vec<Column> {
        let there = of_closure.iter().filter_map(|column| match *column {
            Column::Amplitude { effect, .. } => Some(effect),
            _ => None,
        });
        let both: Vec<(usize, usize)> = there.zip(self.amplitudes.iter().map(|a| a.0)).collect();
        let own = |of: usize| both.iter().find(|(there, _)| *there == of).map_or(of, |both| both.1);
        let here = |column: &Column| match *column {
            Column::Amplitude { effect, parameter } => {
                Column::Amplitude { effect: own(effect), parameter }
            }
            Column::Place { effect, coordinate } => {
                Column::Place { effect: own(effect), coordinate }
            }
            other => other,
        };
        of_closure.iter().map(here).collect()
    }

    fn of(accepted: &Accepted<'_>, model: &'m dyn Model) -> Option<Self> {
        let declared = model.declared();
        let place = |Amplitude { effect: (id, subject), parameter, .. }: &Amplitude| {
            let is_it = |effect: &Effect| effect.id == *id && effect.subject == *subject;
            let effect = declared.effects.iter().position(is_it)?;
            (*parameter < declared.effects[effect].parameters.len()).then_some((effect, *parameter))
        };
        let layout = &declared.layout;
        let is_fitted = |row: &usize| {
            let group = layout.observations.get(layout.rows[*row].observation);
            group.is_none_or(|group| layout.groups[*group].role != Role::Check)
        };
        let columns = accepted.closure.empirical.iter().map(|e| e.columns.column_iter());
        let columns: Vec<DVector<f64>> = columns.flatten().map(Matrix::into_owned).collect();
        let n_rows = layout.rows.len();
        let mut added = DMatrix::zeros(n_rows, columns.len());
        for (k, column) in columns.iter().enumerate() {
            (column.len() == n_rows).then(|| added.set_column(k, column))?;
        }
        Some(Self {
            model,
            amplitudes: accepted.amplitudes.iter().map(place).collect::<Option<_>>()?,
            added,
            rows: (0..n_rows).filter(is_fitted).collect(),
        })
    }

    fn n_base(&self) -> usize {
        self.model.declared().base.len()
    }

    fn amplitudes(&self) -> Range<usize> {
        self.n_base()..self.n_base() + self.amplitudes.len()
    }

    fn empirical(&self) -> Range<usize> {
        self.amplitudes().end..self.amplitudes().end + self.added.ncols()
    }

    fn start(&self, accepted: &Accepted<'_>) -> DVector<f64> {
        let base = self.model.declared().start.iter().copied();
        let amplitudes = accepted.amplitudes.iter().map(|a| a.value / a.factor);
        let empirical = accepted.closure.empirical.iter().flat_map(|e| e.coefficients.iter());
        DVector::from_vec(base.chain(amplitudes).chain(empirical.copied()).collect())
    }

    fn state(&self, at: &DVector<f64>) -> State {
        let base = at.rows(0, self.n_base()).into_owned();
        let mut state = State::declared(base, &self.model.declared().effects);
        for ((effect, parameter), value) in
            self.amplitudes.iter().zip(&at.as_slice()[self.amplitudes()])
        {
            state.amplitudes[*effect][*parameter] = *value;
        }
        state
    }

    fn residuals_of_all(&self, at: &DVector<f64>) -> DVector<f64> {
        let empirical = self.empirical();
        let coefficients = at.rows(empirical.start, empirical.len());
        self.model.residuals(&self.state(at)) + &self.added * coefficients
    }

    fn sigma(&self, row: usize) -> f64 {
        self.model.declared().layout.rows[row].sigma
    }
}

impl Problem for Free<'_> {
    type Point = DVector<f64>;

    fn residual_count(&self) -> usize {
        self.rows.len()
    }

    fn tangent_dim(&self) -> usize {
        self.empirical().end
    }

    fn residuals(&self, at: &DVector<f64>, out: &mut DVector<f64>) {
        let all = self.residuals_of_all(at);
        for (whitened, row) in out.iter_mut().zip(&self.rows) {
            *whitened = all[*row] / self.sigma(*row);
        }
    }

    fn jacobian(&self, at: &DVector<f64>, out: &mut DMatrix<f64>) {
        let state = self.state(at);
        let base = self.model.base_jacobian(&state);
        let tangents: Vec<DVector<f64>> = (self.amplitudes.iter())
            .map(|(effect, parameter)| {
                whole_tangent(self.model, &state, *effect).column(*parameter).into_owned()
            })
            .collect();
        for (i, row) in self.rows.iter().enumerate() {
            let weight = 1.0 / self.sigma(*row);
            let entries = base.row(*row).iter().copied().collect::<Vec<_>>().into_iter();
            let entries = entries
                .chain(tangents.iter().map(|tangent| tangent[*row]))
                .chain(self.added.row(*row).iter().copied().collect::<Vec<_>>());
            for (k, entry) in entries.enumerate() {
                out[(i, k)] = weight * entry;
            }
        }
    }

    fn retract(&self, at: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        at + step
    }
}
