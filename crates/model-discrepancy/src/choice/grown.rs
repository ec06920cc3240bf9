//! Amplitudes of an accepted effect that the design hardly shows.

use crate::algebra::system::rows_of;
use crate::choice::candidate::{Estimability, Source, estimability_of_least};
use crate::choice::context::Context;
use crate::choice::selected::{Selected, within_limits};
use crate::levels::{DECIDED, MIN_KEPT_CONFOUNDED};
use crate::tests::significance::significance;

/// Gives accepted effects the amplitudes that the design hardly shows, where the residual has them.
///
/// No effect is looked for by such an amplitude: small errors of the design would pass for it. But a
/// stand that is seen to move along two axes moves along the third one as well, and what that does
/// would get another name.
pub(crate) fn grow(context: &Context<'_>, keep: &[bool], chosen: &mut Selected<'_>) {
    let effects: Vec<usize> = chosen.system.active.iter().map(|a| a.effect).collect();
    for effect in effects {
        grow_one(context, keep, chosen, effect);
    }
}

fn grow_one(context: &Context<'_>, keep: &[bool], chosen: &mut Selected<'_>, effect: usize) {
    let all = context.model.declared().effects[effect].parameters.len();
    let position = chosen.system.active.iter().position(|a| a.effect == effect);
    let Some(position) = position.filter(|&i| chosen.system.active[i].parameters.len() < all)
    else {
        return;
    };
    let lin = context.linear(&chosen.system, &chosen.estimate, keep);
    let beside = (&lin, &lin.basis);
    let seen =
        estimability_of_least(context.model, effect, &chosen.estimate, beside, MIN_KEPT_CONFOUNDED);
    let Estimability::Estimable(rest) = seen else { return };
    let Source::Effect(more) = &rest.source else { return };
    let test = significance(&lin, &lin.basis, &rest.tangent, rest.reach, DECIDED);
    if test.is_none_or(|test| test.p_value > DECIDED) {
        return;
    }
    let mut system = chosen.system.clone();
    let parameters = &mut system.active[position].parameters;
    parameters.extend(&more.parameters);
    parameters.sort_unstable();
    parameters.dedup();
    let rows = rows_of(&context.model.declared().layout, keep);
    let Ok(estimate) = system.fit_anew(&rows, &system.warm_start(&chosen.estimate)) else { return };
    if within_limits(&system, &estimate) {
        (chosen.system, chosen.estimate) = (system, estimate);
    }
}
