//! Which further measurement would tell rivals apart, or make an effect visible.

use nalgebra::DVector;

use crate::attribution::Attribution;
use crate::candidate::{Sight, Source, sight};
use crate::linear::{Linear, NEW_DIRECTION};
use crate::system::{Active, Estimate, System, whitened};
use crate::validate::ORDER;
use crate::{Model, Role};

/// A proposal within this share of the best separation is as good, and the cheaper one is named.
const AS_GOOD: f64 = 0.7;

/// A measurement is worth proposing when it separates the rivals by this many times more.
const WORTHWHILE: f64 = 1.5;

/// The measurement, out of those the user could make, that would split the class best.
pub(crate) fn separate_by(
    attribution: &Attribution<'_>,
    estimate: &Estimate,
    silent: &[bool],
) -> Option<String> {
    let Source::Effect(active) = &attribution.accepted.source else {
        return covariate_advice(attribution);
    };
    let model = attribution.system.model;
    let rivals: Vec<_> = (attribution.rivals.iter())
        .filter_map(|r| match &r.source {
            Source::Effect(a) => Some(a.effect),
            Source::Empirical(_) => None,
        })
        .collect();
    if rivals.is_empty() {
        return covariate_advice(attribution);
    }
    let amplitude = &estimate.state.amplitudes[active.effect];
    let others: Vec<_> = attribution.system.active.iter().map(|a| a.effect).collect();
    let reach = |extended: &dyn Model| {
        distance(model, extended, silent, active.effect, &rivals, &others, amplitude).unwrap_or(0.0)
    };
    let present = reach(model);
    let proposals = model.proposals();
    let distances: Vec<_> = proposals.iter().map(|p| reach(p.model.as_ref())).collect();
    let best = distances.iter().copied().fold(0.0, f64::max);
    let worthwhile = best > WORTHWHILE * present && best > NEW_DIRECTION * amplitude.norm();
    let cheapest = distances.iter().position(|&d| d >= AS_GOOD * best)?;
    worthwhile.then(|| proposals[cheapest].text.clone())
}

fn covariate_advice(attribution: &Attribution<'_>) -> Option<String> {
    attribution.rivals.iter().find_map(|r| match &r.source {
        Source::Empirical(e) if e.covariate == ORDER => Some(
            "repeat the readings in another order, so that time and the other conditions do not run together"
                .to_owned(),
        ),
        Source::Empirical(e) => Some(format!(
            "vary {} independently of the other conditions, or hold it constant",
            e.covariate
        )),
        Source::Effect(_) => None,
    })
}

/// Length, in whitened units, of what effect `accepted` at `amplitude` leaves beside its nearest
/// rival in the design of `extended`.
fn distance(
    model: &dyn Model,
    extended: &dyn Model,
    silent: &[bool],
    accepted: usize,
    rivals: &[usize],
    others: &[usize],
    amplitude: &DVector<f64>,
) -> Option<f64> {
    let twin = |effect: usize| twin(model, extended, effect);
    let system = others.iter().filter_map(|&o| twin(o)).fold(System::declared(extended), |s, e| {
        let parameters = (0..extended.effects()[e].parameters.len()).collect();
        s.with_effect(Active { effect: e, parameters })
    });
    let at = system.start();
    let lin = Linear::of(&system, &at, &all_fitted(extended), silent);
    let effect = |e: usize| lin.tangent(&extended.tangent(&at.state, e));
    let trace = effect(twin(accepted)?) * amplitude;
    rivals
        .iter()
        .filter_map(|&r| twin(r))
        .map(|r| lin.basis.with(&effect(r), NEW_DIRECTION).reject(&trace).norm())
        .min_by(f64::total_cmp)
}

pub(crate) fn all_fitted(model: &dyn Model) -> Vec<bool> {
    model.layout().groups.iter().map(|g| g.role == Role::Fit).collect()
}

/// The cheapest measurement with which the design would see `effect`.
pub(crate) fn make_visible(model: &dyn Model, effect: usize, silent: &[bool]) -> Option<String> {
    let found = model.proposals().into_iter().find(|p| {
        twin(model, p.model.as_ref(), effect).is_some_and(|e| sees(p.model.as_ref(), e, silent))
    });
    if let Some(proposal) = found {
        return Some(proposal.text);
    }
    let names: Vec<_> = (0..silent.len())
        .filter(|&c| silent[c])
        .map(|c| ["x", "y", "z"].get(c).copied().unwrap_or("the other components"))
        .collect();
    (!names.is_empty() && sees(model, effect, &[])).then(|| {
        format!("measure {} as well: both sides hold the same numbers", names.join(" and "))
    })
}

/// The same effect in an extended model.
fn twin(model: &dyn Model, extended: &dyn Model, effect: usize) -> Option<usize> {
    let wanted = &model.effects()[effect];
    extended.effects().iter().position(|e| e.id == wanted.id && e.subject == wanted.subject)
}

fn sees(model: &dyn Model, effect: usize, silent: &[bool]) -> bool {
    let system = System::declared(model);
    let at = system.start();
    let lin = Linear::of(&system, &at, &all_fitted(model), silent);
    matches!(sight(model, effect, &at, &lin, &lin.basis), Sight::Seen(_))
}

/// Parameters of the system that together imitate an effect the design cannot see.
///
/// Named are those that contribute at least a third of the largest.
pub(crate) fn aliased_with(
    system: &System<'_>,
    at: &Estimate,
    lin: &Linear<'_>,
    effect: usize,
) -> Vec<String> {
    const NAMED: f64 = 1.0 / 3.0;
    let jacobian = whitened(lin.layout, at, &lin.rows, &system.jacobian(at));
    let tangent = lin.tangent(&system.model.tangent(&at.state, effect));
    let lengths: Vec<_> = jacobian.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    let mut scaled = jacobian;
    for (mut column, length) in scaled.column_iter_mut().zip(&lengths) {
        column.unscale_mut(*length);
    }
    if scaled.ncols() == 0 || tangent.norm() == 0.0 {
        return Vec::new();
    }
    let Ok(shares) = scaled.svd(true, true).solve(&tangent, NEW_DIRECTION) else {
        return Vec::new();
    };
    let share = |row: usize| shares.row(row).norm();
    let largest = (0..lengths.len()).map(share).fold(0.0, f64::max);
    let names = system.parameter_names();
    (0..lengths.len()).filter(|&i| share(i) >= NAMED * largest).map(|i| names[i].clone()).collect()
}
