//! The conclusion.

use crate::answer::external_validation::check_distance;
use crate::choice::context::Context;
use crate::choice::selected::Selected;
use crate::noise::linear::Linear;
use crate::tests::global_test::{GlobalTest, global_test};
use crate::{Remaining, Role, Verdict};

/// `is_noisier` says whether the data scatter more than declared.
pub(crate) fn verdict(
    context: &Context<'_>,
    chosen: &Selected<'_>,
    remaining: &[Remaining],
    is_noisier: bool,
) -> Verdict {
    if !remaining.is_empty() || many_bad_readings(context, chosen) {
        return Verdict::StructureRemains;
    }
    if is_noisier {
        return Verdict::NoiseLargerThanDeclared;
    }
    if chosen.added.is_empty() { Verdict::NothingMissing } else { Verdict::Explained }
}

/// Whether fitted groups, or these and the check groups together, scatter more than declared.
pub(crate) fn noisier_than_declared(
    context: &Context<'_>,
    lin: &Linear<'_>,
    chosen: &Selected<'_>,
) -> bool {
    let Some(fitted) = global_test(&chosen.system, &chosen.estimate, lin) else { return false };
    let with_check = check_distance(context, chosen, lin, &|row| row.sigma).is_some_and(|check| {
        GlobalTest { chi2: fitted.chi2 + check.square, dof: fitted.dof + check.rows, ..fitted }
            .is_above()
    });
    fitted.is_above() || with_check
}

/// More single bad readings than two, and than one group in twenty, are no accidents.
pub(crate) fn many_bad_readings(context: &Context<'_>, chosen: &Selected<'_>) -> bool {
    let effects = &context.model.declared().effects;
    let bad = chosen.system.active.iter().filter(|a| effects[a.effect].subject.is_some()).count();
    let groups =
        context.model.declared().layout.groups.iter().filter(|g| g.role == Role::Fit).count();
    bad > 2.max(groups / 20)
}
