//! The conclusion.

use crate::answer::external_validation::check_distance;
use crate::answer::structure::{is_forgotten, is_memory};
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

/// χ² over degrees of freedom of noise that was declared twice as large as it is: of less nobody knows what it hides.
const HALF_SQUARED: f64 = 0.25;

/// Takes readings that go with the one before off what is left, where nothing else is and all scatter as they were declared
/// to, or, where nothing was declared, remember the one before and no more: noise with memory, and what to say of it.
pub(crate) fn memory_within_the_noise(
    chosen: &Selected<'_>,
    lin: &Linear<'_>,
    remaining: &mut Vec<Remaining>,
) -> Option<String> {
    if remaining.is_empty() || !remaining.iter().all(is_memory) {
        return None;
    }
    let said = match global_test(&chosen.system, &chosen.estimate, lin) {
        Some(test) if test.per_dof() >= HALF_SQUARED && !test.is_above() => {
            "successive residuals go together, and scatter no more than declared: the noise has memory, or something \
             smaller than it drifts to and fro"
        }
        None if is_forgotten(lin) => {
            "successive residuals go together, each with the one before and no longer: the noise has memory, or \
             something as fast and as large as it goes to and fro"
        }
        _ => return None,
    };
    remaining.clear();
    Some(said.to_owned())
}

/// More single bad readings than two, and than one group in twenty, are no accidents.
pub(crate) fn many_bad_readings(context: &Context<'_>, chosen: &Selected<'_>) -> bool {
    let effects = &context.model.declared().effects;
    let bad = chosen.system.active.iter().filter(|a| effects[a.effect].subject.is_some()).count();
    let groups =
        context.model.declared().layout.groups.iter().filter(|g| g.role == Role::Fit).count();
    bad > 2.max(groups / 20)
}
