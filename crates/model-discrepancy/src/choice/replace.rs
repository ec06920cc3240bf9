//! Catalogue effects that an empirical correction makes superfluous.

use crate::algebra::basis::NEW_DIRECTION;
use crate::algebra::system::rows_of;
use crate::choice::candidate::{Candidate, Estimability, Source, estimability};
use crate::choice::context::Context;
use crate::choice::score_shapes::{recorded, shape_again};
use crate::choice::selected::Selected;
use crate::choice::selected::What;
use crate::levels::NAME_SHARE;
use crate::levels::STAY;
use crate::tests::significance::significance;

/// Takes back catalogue effects that the `newcomer`, just added, explains as well.
///
/// A recorded column that makes an effect superfluous replaces it. Positions and the measured
/// order can imitate any effect, so beside them an effect stays while it accounts for most of
/// what the wider shape finds.
pub(crate) fn replace_superseded(
    context: &Context<'_>,
    keep: &[bool],
    chosen: &mut Selected<'_>,
    newcomer: &Candidate,
) {
    let Source::Empirical(empirical) = &newcomer.source else { return };
    let effects: Vec<_> = chosen.system.active.iter().map(|a| a.effect).collect();
    for effect in effects {
        let replaced =
            without(context, keep, chosen, effect, &empirical.covariate, &empirical.shape);
        if let Some(replaced) = replaced {
            *chosen = replaced;
        }
    }
}

/// The selection without `effect`, when the shape makes it superfluous.
fn without<'a>(
    context: &Context<'_>,
    keep: &[bool],
    chosen: &Selected<'a>,
    effect: usize,
    covariate: &str,
    shape: &str,
) -> Option<Selected<'a>> {
    let mut next = chosen.clone();
    next.system = next.system.without_effect(effect);
    next.system.empirical.pop();
    let rows = rows_of(&context.model.declared().layout, keep);
    next.estimate = next.system.fit(&rows, &next.system.warm_start(&chosen.estimate)).ok()?;
    let lin = context.linear(&next.system, &next.estimate, keep);

    let (wide, base) = shape_again(context, &lin, &lin.basis, covariate, shape)?;
    let Estimability::Estimable(named) =
        estimability(context.model, effect, &next.estimate, &lin, &base)
    else {
        return None;
    };
    let beside = base.with(&wide.tangent, NEW_DIRECTION);
    let still = significance(&lin, &beside, &named.tangent, named.reach, STAY);
    if still.is_some_and(|t| t.p_value <= STAY) {
        return None;
    }
    let gain = |tangent| {
        base.with(tangent, NEW_DIRECTION).explained(&lin.residual) - base.explained(&lin.residual)
    };
    if !recorded(context, covariate) && gain(&named.tangent) >= NAME_SHARE * gain(&wide.tangent) {
        return None;
    }
    next.system = wide.added_to(&next.system);
    next.estimate = next.system.fit_anew(&rows, &next.system.warm_start(&next.estimate)).ok()?;
    next.added.retain(|a| a.what != What::Effect(effect));
    Some(next)
}
