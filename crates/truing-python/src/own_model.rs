//! The loop on a model that is written in Python.

use std::collections::HashMap;
use std::sync::Mutex;

use nalgebra::{DMatrix, DVector};
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use truing::model_discrepancy::{
    self, Closure, Covariate, Declared, Differenced, Effect, ErrorSummary, Group, HoldOut, Layout,
    Options, Parameter, Role, Row, Scope, State, Step, Verdict,
};

use crate::arrays::{column, matrix, std_of_each};
use crate::refusal::Refusal;

/// Name, unit, and what the value is multiplied by to be reported in it.
type OfParameter = (String, String, f64);
/// Name, subject, description, driver, whether some designs do not show it, and amplitudes.
type OfEffect = (String, Option<String>, String, Option<String>, bool, Vec<OfParameter>);
/// Unit, residuals an observation, the group of each observation, groups that are only judged.
type OfLayout = (String, usize, Vec<String>, Vec<String>);

/// Closes the loop on residuals that a Python function computes.
#[pyfunction]
#[pyo3(signature = (residuals, layout, std, base, start, effects, covariates, options))]
pub(crate) fn close_own_loop<'py>(
    py: Python<'py>,
    residuals: Py<PyAny>,
    layout: OfLayout,
    std: Option<PyReadonlyArrayDyn<'py, f64>>,
    base: Vec<OfParameter>,
    start: Vec<f64>,
    effects: Vec<OfEffect>,
    covariates: Vec<(String, Vec<f64>)>,
    options: (f64, usize, bool),
) -> PyResult<Bound<'py, PyDict>> {
    let layout = layout_of(layout, std.as_ref())?;
    let effects = effects.into_iter().map(effect).collect();
    let mut declared = Declared::new(layout, base.into_iter().map(parameter).collect(), effects);
    declared.start = DVector::from_vec(start);
    let covariates: Vec<Covariate> = covariates
        .into_iter()
        .map(|(name, values)| {
            let quantity = truing::quantity_of(&name);
            Covariate::recorded(name, quantity, values)
        })
        .collect();
    let (alpha, max_steps, nested) = options;
    let options = Options { alpha, max_steps, nested, ..Options::default() };
    let n = declared.layout.rows.len();
    let failure = Mutex::new(None);
    let of = |at: &State| computed(&residuals, at, n, &failure);
    let model = Differenced { declared, residuals: of };
    let closed = py.detach(|| model_discrepancy::close_loop(&model, &covariates, &options));
    // What the function itself says is wrong comes before what its numbers led to.
    if let Some(error) = failure.lock().ok().and_then(|mut failed| failed.take()) {
        return Err(error);
    }
    answer(py, &closed.map_err(Refusal::from)?)
}

/// Residuals at a state; the first exception is kept, and everything after it is no number.
fn computed(
    residuals: &Py<PyAny>,
    at: &State,
    n: usize,
    failure: &Mutex<Option<PyErr>>,
) -> DVector<f64> {
    let failed = || failure.lock().map_or(true, |failed| failed.is_some());
    if failed() {
        return DVector::repeat(n, f64::NAN);
    }
    let called = Python::attach(|py| {
        py.check_signals()?;
        let base = PyArray1::from_slice(py, at.base.as_slice());
        let amplitudes: Vec<_> =
            at.amplitudes.iter().map(|a| PyArray1::from_slice(py, a.as_slice())).collect();
        let found = residuals.bind(py).call1((base, amplitudes))?;
        let found: PyReadonlyArray1<'_, f64> = found.extract()?;
        let found = found.as_array();
        if found.len() != n {
            return Err(Refusal::shape("residuals", &n.to_string(), found.shape()).into());
        }
        Ok(DVector::from_iterator(n, found.iter().copied()))
    });
    called.unwrap_or_else(|error: PyErr| {
        if let Ok(mut failed) = failure.lock() {
            failed.get_or_insert(error);
        }
        DVector::repeat(n, f64::NAN)
    })
}

fn layout_of(
    (unit, components, of_observation, judged): OfLayout,
    std: Option<&PyReadonlyArrayDyn<'_, f64>>,
) -> Result<Layout, Refusal> {
    let mut groups: Vec<Group> = Vec::new();
    let mut observations = Vec::with_capacity(of_observation.len());
    // A group counts where it is met first.
    let mut known = HashMap::new();
    for name in of_observation {
        let next = groups.len();
        let group = *known.entry(name.clone()).or_insert(next);
        if group == next {
            let role = if judged.contains(&name) { Role::Check } else { Role::Fit };
            groups.push(Group { name, role });
        }
        observations.push(group);
    }
    if let Some(unknown) = judged.iter().find(|name| !known.contains_key(*name)) {
        return Err(Refusal::of(format!("check names {unknown:?}, which is no group")));
    }
    let n = components * observations.len();
    let sigma = std.map(|std| std_of_each("std", std, n)).transpose()?;
    let row = |i: usize| Row {
        observation: i / components,
        component: i % components,
        sigma: sigma.as_ref().map_or(1.0, |sigma| sigma.of(i)),
        reported: true,
    };
    let rows = (0..n).map(row).collect();
    let sigma_declared = sigma.is_some();
    Ok(Layout { rows, observations, groups, unit, sigma_declared })
}

fn parameter((name, unit, factor): OfParameter) -> Parameter {
    Parameter::new(&name, &unit, factor)
}

fn effect((id, subject, description, driver, some_designs, of): OfEffect) -> Effect {
    let parameters = of.into_iter().map(parameter).collect();
    let scope = if some_designs { Scope::SomeDesigns } else { Scope::Everywhere };
    Effect { subject, driver, ..Effect::new(&id, &description, parameters).within(scope) }
}

fn answer<'py>(py: Python<'py>, closure: &Closure) -> PyResult<Bound<'py, PyDict>> {
    let found = PyDict::new(py);
    found.set_item(
        "verdict",
        match closure.verdict {
            Verdict::NothingMissing => "nothing-missing",
            Verdict::Explained => "explained",
            Verdict::StructureRemains => "structure-remains",
            Verdict::NoiseLargerThanDeclared => "noise-larger-than-declared",
        },
    )?;
    found.set_item("before", summary(py, &closure.before)?)?;
    found.set_item("after", summary(py, &closure.after)?)?;
    let steps: Vec<_> = closure.steps.iter().map(|s| step(py, s)).collect::<PyResult<_>>()?;
    found.set_item("steps", steps)?;
    let remaining = closure.remaining.iter().map(|left| {
        let item = PyDict::new(py);
        item.set_item("covariate", &left.covariate)?;
        item.set_item("shape", &left.shape)?;
        item.set_item("p_value", left.p_value)?;
        Ok(item)
    });
    found.set_item("remaining", remaining.collect::<PyResult<Vec<_>>>()?)?;
    let unseen = closure.not_observable.iter().map(|unseen| {
        let item = PyDict::new(py);
        item.set_item("effect", &unseen.effect)?;
        item.set_item("aliased_with", &unseen.aliased_with)?;
        Ok(item)
    });
    found.set_item("not_observable", unseen.collect::<PyResult<Vec<_>>>()?)?;
    found.set_item("base", column(py, closure.state.base.as_slice().to_vec()))?;
    let amplitudes = closure.state.amplitudes.iter();
    let amplitudes: Vec<_> = amplitudes.map(|a| column(py, a.as_slice().to_vec())).collect();
    found.set_item("amplitudes", amplitudes)?;
    let covariance: &DMatrix<f64> = &closure.covariance;
    found.set_item("covariance", matrix(py, covariance))?;
    found.set_item("residuals_before", column(py, closure.residuals_before.clone()))?;
    found.set_item("residuals_after", column(py, closure.residuals_after.clone()))?;
    found.set_item("warnings", &closure.warnings)?;
    Ok(found)
}

fn summary<'py>(py: Python<'py>, of: &ErrorSummary) -> PyResult<Bound<'py, PyDict>> {
    let found = PyDict::new(py);
    found.set_item("train_rms", of.train_rms)?;
    found.set_item("held_out_rms", of.held_out_rms)?;
    found.set_item("held_out_std", of.held_out_std)?;
    found.set_item("unit", &of.unit)?;
    found.set_item(
        "hold_out",
        match of.hold_out {
            HoldOut::CheckGroups => "check-groups",
            HoldOut::Nested => "nested",
            HoldOut::LeaveOneOut => "leave-one-out",
        },
    )?;
    found.set_item("chi2_per_dof", of.chi2_per_dof)?;
    found.set_item("chi2_interval", of.chi2_interval)?;
    Ok(found)
}

fn step<'py>(py: Python<'py>, of: &Step) -> PyResult<Bound<'py, PyDict>> {
    let found = PyDict::new(py);
    found.set_item("effect", &of.effect)?;
    found.set_item("subject", &of.subject)?;
    found.set_item("description", &of.description)?;
    let parameters = of.parameters.iter().map(|parameter| {
        let item = PyDict::new(py);
        item.set_item("name", &parameter.name)?;
        item.set_item("value", parameter.value)?;
        item.set_item("unit", &parameter.unit)?;
        item.set_item("std", parameter.std)?;
        Ok(item)
    });
    found.set_item("parameters", parameters.collect::<PyResult<Vec<_>>>()?)?;
    found.set_item("p_value", of.p_value)?;
    found.set_item("held_out_rms", of.held_out_rms)?;
    found.set_item("train_rms", of.train_rms)?;
    found.set_item("indistinguishable_from", &of.indistinguishable_from)?;
    found.set_item("rivals", &of.rivals)?;
    found.set_item("separate_by", &of.separate_by)?;
    let stability = PyDict::new(py);
    stability.set_item("resampled", of.stability.resampled)?;
    stability.set_item("perturbed", of.stability.perturbed)?;
    found.set_item("stability", stability)?;
    Ok(found)
}
