//! Names that the data contradict: parts of something that has none in the catalogue.

use crate::Remaining;
use crate::algebra::system::{Estimate, System};
use crate::choice::additivity::{not_additive, plainly_not_additive};
use crate::choice::candidate::label;
use crate::choice::context::Context;
use crate::choice::select::{select, without};
use crate::choice::selected::{Selected, What};
use crate::levels::EXCESS_LEFT;
use crate::noise::linear::Linear;
use crate::tests::global_test::{GlobalTest, global_test};

/// The selection in place of one that the data contradict, and what is said of it where nothing else
/// explains the data either: `context` bans what was named.
///
/// Where another choice does not reach the declared noise, nothing is named.
pub(crate) fn chosen_instead<'a>(
    context: &Context<'a>,
    keep: &[bool],
    base: &Estimate,
    chosen: &Selected<'a>,
    contradiction: Remaining,
) -> (Selected<'a>, Option<Remaining>) {
    let again = select(context, keep, base);
    let reached = scatter(context, keep, &again.system, &again.estimate);
    if !again.added.is_empty() && reached.is_some_and(|test| !test.is_above()) {
        return (again, None);
    }
    let plain = without_names(context, keep, chosen).unwrap_or_else(|| chosen.clone());
    (plain, Some(contradiction))
}

/// Where one of the named effects is not what its name promises, and all of them leave a visible
/// part of the misfit.
///
/// Greedy choice takes a shape that is in no catalogue apart into effects that each explain a piece:
/// a low patch into an ellipsoid, lobes and a travel. What gives them away is that they neither
/// reach the declared noise nor keep their own proportions. Without declared noise nothing is
/// decided here.
pub(crate) fn contradiction(
    context: &Context<'_>,
    keep: &[bool],
    base: &Estimate,
    chosen: &Selected<'_>,
) -> Option<Remaining> {
    let effects = &context.model.declared().effects;
    if !context.model.declared().layout.sigma_declared || chosen.system.active.is_empty() {
        return None;
    }
    let before = scatter(context, keep, &System::declared(context.model), base)?;
    let lin = Linear::of(&chosen.system, &chosen.estimate, keep, context.silent);
    let after = global_test(&chosen.system, &chosen.estimate, &lin)?;
    let left = (after.per_dof() - 1.0) / (before.per_dof() - 1.0);
    if !after.is_above() || left < EXCESS_LEFT {
        return None;
    }
    let mut found = not_additive(context, chosen, &lin);
    found.extend(plainly_not_additive(context, chosen, &lin));
    let worst = found.into_iter().min_by(|a, b| a.p_value.total_cmp(&b.p_value))?;
    let name = |effect: usize| label(&effects[effect].id, effects[effect].subject.as_deref());
    let names: Vec<String> = chosen.system.active.iter().map(|a| name(a.effect)).collect();
    let shape = format!(
        "{}, and {:.0} % of the misfit is left: taken back, with all that was named ({})",
        worst.shape,
        100.0 * left,
        names.join(", ")
    );
    Some(Remaining { shape, ..worst })
}

fn scatter(
    context: &Context<'_>,
    keep: &[bool],
    system: &System<'_>,
    at: &Estimate,
) -> Option<GlobalTest> {
    global_test(system, at, &Linear::of(system, at, keep, context.silent))
}

fn without_names<'a>(
    context: &Context<'a>,
    keep: &[bool],
    chosen: &Selected<'a>,
) -> Option<Selected<'a>> {
    let mut plain = chosen.clone();
    while let Some(index) = plain.added.iter().position(|a| matches!(a.what, What::Effect(_))) {
        plain = without(context, keep, &plain, index)?;
    }
    Some(plain)
}
