//! Estimates of a system with their uncertainty.

use crate::levels::TOO_NOISY;
use nalgebra::DMatrix;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::ParameterEstimate;
use crate::algebra::system::{Estimate, System, rows_of, whitened};
use crate::choice::context::Context;
use crate::choice::selected::Selected;
use crate::choice::selected::What;
use crate::count::count;

/// Covariance of `[base, active amplitudes, empirical coefficients]` in internal units.
///
/// From the QR factor of the column-scaled, whitened Jacobian. Scaled by the variance factor
/// where sigma was not declared, or where χ² shows that it was declared too small.
pub(crate) fn covariance(system: &System<'_>, at: &Estimate, keep: &[bool]) -> DMatrix<f64> {
    let p = system.dim();
    if p == 0 {
        return DMatrix::zeros(0, 0);
    }
    let rows = rows_of(&system.model.declared().layout, keep);
    let mut jacobian = whitened(&system.model.declared().layout, at, &rows, &system.jacobian(at));
    let scale: Vec<_> = jacobian.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    for (mut column, scale) in jacobian.column_iter_mut().zip(&scale) {
        column.unscale_mut(*scale);
    }
    let r = jacobian.qr().r();
    let Some(inverse) = r.solve_upper_triangular(&DMatrix::identity(p, p)) else {
        return DMatrix::from_element(p, p, f64::INFINITY);
    };
    let factor = covariance_factor(system, at, &rows);
    let mut covariance = &inverse * inverse.transpose() * factor;
    for i in 0..p {
        for j in 0..p {
            covariance[(i, j)] /= scale[i] * scale[j];
        }
    }
    covariance
}

fn covariance_factor(system: &System<'_>, at: &Estimate, rows: &[usize]) -> f64 {
    let layout = &system.model.declared().layout;
    let Some(dof) = rows.len().checked_sub(system.dim()).filter(|&d| d > 0) else { return 1.0 };
    let all = system.residuals(at);
    let chi2: f64 = rows.iter().map(|&r| (all[r] / at.sigma(&layout.rows[r])).powi(2)).sum();
    if layout.sigma_declared && !too_noisy(chi2, count(dof)) { 1.0 } else { chi2 / count(dof) }
}

/// Whether χ² says that there is more noise than declared.
pub(crate) fn too_noisy(chi2: f64, dof: f64) -> bool {
    ChiSquared::new(dof).is_ok_and(|d| d.sf(chi2) < TOO_NOISY)
}

/// Amplitudes of one addition in report units.
pub(crate) fn parameter_estimates(
    context: &Context<'_>,
    chosen: &Selected<'_>,
    keep: &[bool],
    what: &What,
) -> Vec<ParameterEstimate> {
    let covariance = covariance(&chosen.system, &chosen.estimate, keep);
    let std = |i: usize| covariance[(i, i)].max(0.0).sqrt();
    let mut column = context.model.declared().base.len();
    for active in &chosen.system.active {
        if *what == What::Effect(active.effect) {
            let effect = &context.model.declared().effects[active.effect];
            let amplitudes = &chosen.estimate.state.amplitudes[active.effect];
            let one = |(i, &p): (usize, &usize)| {
                let parameter = &effect.parameters[p];
                ParameterEstimate {
                    name: parameter.name.clone(),
                    value: amplitudes[p] * parameter.report_factor,
                    unit: parameter.unit.clone(),
                    std: std(column + i) * parameter.report_factor.abs(),
                }
            };
            return active.parameters.iter().enumerate().map(one).collect();
        }
        column += active.parameters.len();
    }
    for (empirical, coefficients) in
        chosen.system.empirical.iter().zip(&chosen.estimate.coefficients)
    {
        if *what == What::Empirical(empirical.covariate.clone(), empirical.shape.clone()) {
            let unit = &context.model.declared().layout.unit;
            let one = |(i, name): (usize, &String)| ParameterEstimate {
                name: name.clone(),
                value: coefficients[i],
                unit: unit_of(unit, name),
                std: std(column + i),
            };
            return empirical.coefficients.iter().enumerate().map(one).collect();
        }
        column += empirical.columns.ncols();
    }
    Vec::new()
}

/// `mm` for a coefficient, `mm/c` for one «per c».
fn unit_of(unit: &str, coefficient: &str) -> String {
    let per = coefficient.split_once("per ").and_then(|(_, rest)| rest.split([' ', ',']).next());
    per.map_or_else(|| unit.to_owned(), |per| format!("{unit}/{per}"))
}
