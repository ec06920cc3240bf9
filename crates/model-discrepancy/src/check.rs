//! Analytic tangents against differences.

use nalgebra::{DMatrix, DVector};

use crate::{Model, State};

/// Relative step of the central difference: the cube root of the machine epsilon balances
/// truncation and round-off.
const STEP: f64 = 6e-6;

/// Worst discrepancy between analytic derivatives and central differences, relative to the
/// longest entry of each column; use it in the tests of every [`Model`].
///
/// Checks the base Jacobian and the tangent of every effect. About 1e-8 is the best that
/// differences can show; residuals that are far from linear over `1e-5` of a parameter show more.
#[must_use]
pub fn check_tangents(model: &dyn Model, at: &State) -> f64 {
    let mut worst = discrepancy(&model.base_jacobian(at), |column, step| {
        let mut moved = at.clone();
        moved.base[column] += step;
        (model.residuals(&moved), at.base[column])
    });
    for effect in 0..model.effects().len() {
        let here = discrepancy(&model.tangent(at, effect), |column, step| {
            let mut moved = at.clone();
            moved.amplitudes[effect][column] += step;
            (model.residuals(&moved), at.amplitudes[effect][column])
        });
        worst = f64::max(worst, here);
    }
    worst
}

/// `moved(column, step)` gives the residuals after a step, and the parameter before it.
fn discrepancy(analytic: &DMatrix<f64>, moved: impl Fn(usize, f64) -> (DVector<f64>, f64)) -> f64 {
    let mut worst = 0.0_f64;
    for (column, exact) in analytic.column_iter().enumerate() {
        // Residuals are small numbers: a step that moves the longest by about 1e-3 of a unit, or
        // a small share of the parameter itself.
        let (residual, value) = moved(column, 0.0);
        let size = exact.amax();
        let natural = if size > 0.0 { residual.amax().max(1.0) / size } else { 1.0 };
        let step = STEP * natural.max(value.abs());
        let difference = (moved(column, step).0 - moved(column, -step).0) / (2.0 * step);
        let scale = size.max(difference.amax());
        if scale > 0.0 {
            worst = worst.max((difference - exact).amax() / scale);
        }
        if !difference_is_finite(&residual) {
            return f64::INFINITY;
        }
    }
    worst
}

fn difference_is_finite(residual: &DVector<f64>) -> bool {
    residual.iter().all(|v| v.is_finite())
}
