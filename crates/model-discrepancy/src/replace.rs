//! Catalogue effects that an empirical correction makes superfluous.

use crate::candidate::{Candidate, Sight, Source, sight};
use crate::judge::{Setting, recorded, shape_again};
use crate::linear::{Linear, NEW_DIRECTION};
use crate::select::{STAY, Selected, What};
use crate::significance::significance;
use crate::system::rows_of;

/// Share of what a wider empirical shape explains that an effect must account for to keep its
/// name: with less, the name leaves a visible part of the same structure unexplained.
const NAME_SHARE: f64 = 0.9;

/// Takes back catalogue effects that the `newcomer`, just added, explains as well.
///
/// A recorded column that makes an effect superfluous replaces it. Positions and the measured
/// order can imitate any effect, so beside them an effect stays while it accounts for most of
/// what the wider shape finds.
pub(crate) fn replace_superseded(
    setting: &Setting<'_>,
    keep: &[bool],
    chosen: &mut Selected<'_>,
    newcomer: &Candidate,
) {
    let Source::Empirical(empirical) = &newcomer.source else { return };
    let effects: Vec<_> = chosen.system.active.iter().map(|a| a.effect).collect();
    for effect in effects {
        let replaced =
            without(setting, keep, chosen, effect, &empirical.covariate, &empirical.shape);
        if let Some(replaced) = replaced {
            *chosen = replaced;
        }
    }
}

/// The selection without `effect`, when the shape makes it superfluous.
fn without<'a>(
    setting: &Setting<'_>,
    keep: &[bool],
    chosen: &Selected<'a>,
    effect: usize,
    covariate: &str,
    shape: &str,
) -> Option<Selected<'a>> {
    let mut next = chosen.clone();
    next.system = next.system.without_effect(effect);
    next.system.empirical.pop();
    let rows = rows_of(&setting.model.declared().layout, keep);
    next.estimate = next.system.fit(&rows, &next.system.carry(&chosen.estimate)).ok()?;
    let lin = Linear::of(&next.system, &next.estimate, keep, setting.silent);

    let (wide, base) = shape_again(setting, &lin, &lin.basis, covariate, shape)?;
    let Sight::Seen(named) = sight(setting.model, effect, &next.estimate, &lin, &base) else {
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
    if !recorded(setting, covariate) && gain(&named.tangent) >= NAME_SHARE * gain(&wide.tangent) {
        return None;
    }
    next.system = wide.added_to(&next.system);
    next.estimate = next.system.fit_anew(&rows, &next.system.carry(&next.estimate)).ok()?;
    next.added.retain(|a| a.what != What::Effect(effect));
    Some(next)
}
