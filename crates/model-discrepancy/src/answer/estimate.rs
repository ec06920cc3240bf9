//! Estimates of a system with their uncertainty.

use crate::levels::TOO_NOISY;
use nalgebra::DMatrix;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::algebra::system::{Estimate, System, rows_of, whitened};
use crate::choice::context::Context;
use crate::choice::selected::Selected;
use crate::choice::selected::What;
use crate::count::count;
use crate::{Column, ParameterEstimate};

/// What a closed loop says of its parameters, places at which effects were found included.
pub(crate) struct Uncertain {
    /// What each row and column of the others is about.
    pub(crate) columns: Vec<Column>,
    /// Of the residual, all rows.
    pub(crate) jacobian: DMatrix<f64>,
    /// In internal units.
    pub(crate) covariance: DMatrix<f64>,
    /// That it goes by.
    pub(crate) noise: NoiseLevel,
}

impl Uncertain {
    /// Of `[base, active amplitudes, empirical coefficients, places]`.
    ///
    /// From the QR factor of the column-scaled, whitened Jacobian. Scaled by the variance factor
    /// where sigma was not declared, or where χ² shows that it was declared too small.
    pub(crate) fn of(system: &System<'_>, at: &Estimate, keep: &[bool]) -> Self {
        let jacobian = system.jacobian_with_places(at);
        let columns = system.columns().into_iter().chain(system.places()).collect();
        let rows = rows_of(&system.model.declared().layout, keep);
        let noise = noise_level(system, at, &rows);
        let white = whitened(&system.model.declared().layout, at, &rows, &jacobian);
        let covariance = covariance(white, noise.variance_factor);
        Self { columns, jacobian, covariance, noise }
    }
}

/// Inverse of the information of whitened columns, times a factor.
fn covariance(mut jacobian: DMatrix<f64>, factor: f64) -> DMatrix<f64> {
    let p = jacobian.ncols();
    if p == 0 {
        return DMatrix::zeros(0, 0);
    }
    let scale: Vec<_> = jacobian.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    for (mut column, scale) in jacobian.column_iter_mut().zip(&scale) {
        column.unscale_mut(*scale);
    }
    let r = jacobian.qr().r();
    let Some(inverse) = r.solve_upper_triangular(&DMatrix::identity(p, p)) else {
        return DMatrix::from_element(p, p, f64::INFINITY);
    };
    let mut covariance = &inverse * inverse.transpose() * factor;
    for i in 0..p {
        for j in 0..p {
            covariance[(i, j)] /= scale[i] * scale[j];
        }
    }
    covariance
}

/// By how much the noise differs from what was declared, as covariances count it.
pub(crate) struct NoiseLevel {
    pub(crate) variance_factor: f64,
    /// `None` where the factor is not estimated.
    pub(crate) degrees_of_freedom: Option<usize>,
}

/// The noise in `rows` at the end of a fit.
pub(crate) fn noise_level(system: &System<'_>, at: &Estimate, rows: &[usize]) -> NoiseLevel {
    let layout = &system.model.declared().layout;
    let declared = NoiseLevel { variance_factor: 1.0, degrees_of_freedom: None };
    let fitted = system.dim() + system.places().len();
    let Some(dof) = rows.len().checked_sub(fitted).filter(|&d| d > 0) else {
        return declared;
    };
    let all = system.residuals(at);
    let chi2: f64 = rows.iter().map(|&r| (all[r] / at.sigma(&layout.rows[r])).powi(2)).sum();
    if layout.sigma_declared && !too_noisy(chi2, count(dof)) {
        return declared;
    }
    NoiseLevel { variance_factor: chi2 / count(dof), degrees_of_freedom: Some(dof) }
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
    let Uncertain { covariance, .. } = Uncertain::of(&chosen.system, &chosen.estimate, keep);
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
