//! The residual as readings: one value of one component of one observation.

use std::collections::HashSet;

use model_discrepancy::{Layout, Role, Row};

use super::axis::drawable;
use super::number::real;

/// One reported residual, in the unit shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reading {
    pub(crate) observation: usize,
    pub(crate) component: usize,
    pub(crate) value: f64,
    /// Standard uncertainty, in the unit shown.
    pub(crate) sigma: f64,
    /// Not fitted, only judged.
    pub(crate) check: bool,
}

/// Reported residuals of fitted and judged groups that can be drawn, in row order.
pub(crate) fn readings(layout: &Layout, residuals: &[f64], factor: f64) -> Vec<Reading> {
    let reading = |(row, residual): (&Row, &f64)| {
        let group = layout.groups.get(*layout.observations.get(row.observation)?)?;
        let value = factor * residual;
        let shown = row.reported && group.role != Role::Prior && drawable(value);
        shown.then_some(Reading {
            observation: row.observation,
            component: row.component,
            value,
            sigma: factor * row.sigma,
            check: group.role == Role::Check,
        })
    };
    layout.rows.iter().zip(residuals).filter_map(reading).collect()
}

/// Number of components that occur.
pub(crate) fn component_count(readings: &[Reading]) -> usize {
    readings.iter().map(|r| r.component + 1).max().unwrap_or(0)
}

/// Name of a component, also where the caller gave none.
pub(crate) fn component_name(names: &[String], component: usize) -> String {
    names.get(component).cloned().unwrap_or_else(|| format!("component {}", component + 1))
}

/// Root mean square per observation, `None` where there is none.
pub(crate) fn rms(readings: &[Reading]) -> Option<f64> {
    let observations: HashSet<usize> = readings.iter().map(|r| r.observation).collect();
    let n = real(observations.len());
    let sum: f64 = readings.iter().map(|r| r.value * r.value / n).sum();
    (!readings.is_empty()).then(|| sum.sqrt())
}
