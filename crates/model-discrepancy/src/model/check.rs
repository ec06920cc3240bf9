//! Analytic tangents against differences.

use nalgebra::{DMatrix, DVector};

use super::differences::{difference, natural_step};
use super::validate::fits_layout;
use super::{Declared, Model, Scope, State, whole_tangent};

/// Worst discrepancy between analytic derivatives and central differences, relative to the
/// longest entry of each column; use it in the tests of every [`Model`].
///
/// Checks the base Jacobian and the tangent of every effect. About 1e-8 is the best that
/// differences can show; residuals that are far from linear over `1e-5` of a parameter show more.
/// Infinite where residuals are not finite, where `at` has not one number per declared parameter,
/// where what is declared beside the layout does not fit it, as [`Effect::by_place`](crate::Effect::by_place)
/// with other rows, and where a column is zero, analytic and by differences, although the effect is to be seen in
/// every design ([`Scope::Everywhere`]).
#[must_use]
pub fn check_tangents(model: &dyn Model, at: &State) -> f64 {
    if !is_state(model, at)
        || fits_layout(model).is_err()
        || !model.residuals(at).iter().all(|v| v.is_finite())
    {
        return f64::INFINITY;
    }
    let base = model.base_jacobian(at);
    let of_base = |i: usize| discrepancy(model, at, &base, i, false, |at| &mut at.base[i]);
    let mut worst = (0..base.ncols()).map(of_base).fold(0.0, f64::max);
    for (e, effect) in model.declared().effects.iter().enumerate() {
        let tangent = whole_tangent(model, at, e);
        let may_vanish = effect.scope == Scope::SomeDesigns;
        for i in 0..tangent.ncols() {
            let here =
                discrepancy(model, at, &tangent, i, may_vanish, |at| &mut at.amplitudes[e][i]);
            worst = worst.max(here);
        }
    }
    worst
}

/// Whether `at` has one number per declared parameter.
fn is_state(model: &dyn Model, at: &State) -> bool {
    let Declared { base, effects, .. } = model.declared();
    let amplitudes = || at.amplitudes.iter().zip(effects);
    at.base.len() == base.len()
        && at.amplitudes.len() == effects.len()
        && amplitudes().all(|(amplitude, effect)| amplitude.len() == effect.parameters.len())
}

fn discrepancy(
    model: &dyn Model,
    at: &State,
    analytic: &DMatrix<f64>,
    column: usize,
    may_vanish: bool,
    of: impl Fn(&mut State) -> &mut f64,
) -> f64 {
    let exact: DVector<f64> = analytic.column(column).into_owned();
    let natural = natural_step(model, at, &exact);
    let by_difference = difference(model, at, &of, if natural > 0.0 { natural } else { 1.0 });
    let scale = exact.amax().max(by_difference.amax());
    if scale > 0.0 {
        (by_difference - exact).amax() / scale
    } else if may_vanish {
        0.0
    } else {
        f64::INFINITY
    }
}
