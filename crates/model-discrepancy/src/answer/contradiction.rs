//! Names that the data contradict: parts of something that has none in the catalogue.

use std::collections::BTreeSet;

use crate::algebra::system::{Estimate, System, rows_of};
use crate::answer::left_over::structured;
use crate::answer::structure::is_memory;
use crate::answer::verdict::many_bad_readings;
use crate::choice::additivity::{not_additive, plainly_not_additive};
use crate::choice::candidate::label;
use crate::choice::context::Context;
use crate::choice::score::home_of_bad;
use crate::choice::select::{select, without};
use crate::choice::selected::{Selected, What};
use crate::levels::{
    BEYOND_DOUBT, EXCESS_LEFT, EXCESS_LEFT_UNDECLARED, GROSS_SCATTER, GROSS_STRUCTURE,
    HARDLY_EXPLAINED, LARGE_SCATTER, MANY_NAMES, MOST_NAMES, MOSTLY_LEFT, STRUCTURE_LEFT,
};
use crate::noise::linear::Linear;
use crate::tests::global_test::{GlobalTest, global_test};
use crate::{Quantity, Remaining};

/// The selection in place of one that the data contradict, and what is said of it where nothing else
/// explains the data either: `context` bans what was named.
///
/// Where another choice does not reach the declared noise, or without that the same misfit, nothing
/// is named.
pub(crate) fn chosen_instead<'a>(
    context: &Context<'a>,
    keep: &[bool],
    base: &Estimate,
    chosen: &Selected<'a>,
    contradicted: Remaining,
) -> (Selected<'a>, Option<Remaining>) {
    let again = select(context, keep, base);
    let left = |by: &Selected<'_>| misfit(keep, &by.system, &by.estimate);
    let reached = scatter(context, keep, &again.system, &again.estimate)
        .map_or_else(|| left(&again) <= left(chosen), |test| !test.is_above());
    if !again.added.is_empty() && reached && contradiction(context, keep, base, &again).is_none() {
        return (again, None);
    }
    let plain = without_names(context, keep, chosen).unwrap_or_else(|| chosen.clone());
    (plain, Some(contradicted))
}

/// Where one of the named effects is not what its name promises, or something larger than all of
/// them has no name.
///
/// Greedy choice takes a shape that is in no catalogue apart into effects that each explain a piece:
/// a low patch into an ellipsoid, lobes and a travel; a head that slips into a platform that is
/// higher. What gives them away is that they do not keep their own proportions, and that a visible
/// part of the misfit follows these departures; or that they do not reach the declared noise, and
/// leave most of the misfit to neighbours that agree, or nearly all of it to anything, or a visible part of
/// it several times as large as the noise, or to structure that one that is not beyond doubt may be a part of; or that
/// several need a correction without a cause beside them. The
/// misfit is what they found: that of the declared model with whatever was corrected without a cause.
pub(crate) fn contradiction(
    context: &Context<'_>,
    keep: &[bool],
    base: &Estimate,
    chosen: &Selected<'_>,
) -> Option<Remaining> {
    if chosen.system.active.is_empty() {
        return None;
    }
    let lin = Linear::of(&chosen.system, &chosen.estimate, keep, context.silent);
    let plain = (!chosen.system.empirical.is_empty())
        .then(|| without_names(context, keep, chosen))
        .flatten();
    let declared = System::declared(context.model);
    let before = plain.as_ref().map_or((&declared, base), |p| (&p.system, &p.estimate));
    let left = too_many(context, chosen, &lin)
        .or_else(|| departed(context, keep, before, chosen, &lin))
        .or_else(|| left_above(context, keep, before, chosen, &lin))
        .map(|(worst, left)| (worst, left, "is left"));
    let corrected = || {
        let (worst, taken) = parts_beside_correction(context, keep, base, chosen, &lin)?;
        Some((worst, taken, "goes with it"))
    };
    let (worst, share, how) = left.or_else(corrected)?;
    let effects = &context.model.declared().effects;
    let name = |effect: usize| label(&effects[effect].id, effects[effect].subject.as_deref());
    let names: Vec<String> = chosen.system.active.iter().map(|a| name(a.effect)).collect();
    let shape = format!(
        "{}, and {} of the misfit {how}: taken back, with all that was named ({})",
        worst.shape,
        if share < 0.01 { "less than 1 %".to_owned() } else { format!("{:.0} %", 100.0 * share) },
        names.join(", ")
    );
    Some(Remaining { shape, ..worst })
}

/// More different names than an answer may have, or as many beside structure that has none: parts that something
/// without a name is made of.
fn too_many(
    context: &Context<'_>,
    chosen: &Selected<'_>,
    lin: &Linear<'_>,
) -> Option<(Remaining, f64)> {
    let ids = different_names(context, chosen, lin);
    let last = chosen.added.last().filter(|_| ids >= MOST_NAMES)?;
    if ids == MOST_NAMES {
        let left = structured(context, chosen, lin).into_iter().filter(|left| !is_memory(left));
        return left.min_by(|a, b| a.p_value.total_cmp(&b.p_value)).map(|worst| (worst, 0.0));
    }
    let shape = format!("{ids} different effects would be needed");
    Some((Remaining { covariate: "names".to_owned(), shape, p_value: last.p_value }, 0.0))
}

/// The departure of a name that takes most of the misfit `before` all names, and its share of that.
fn departed(
    context: &Context<'_>,
    keep: &[bool],
    (system, at): (&System<'_>, &Estimate),
    chosen: &Selected<'_>,
    lin: &Linear<'_>,
) -> Option<(Remaining, f64)> {
    let before = misfit(keep, system, at);
    let after = misfit(keep, &chosen.system, &chosen.estimate);
    // What the departure takes, in the same units.
    let clean = lin.clean_residual().norm_squared();
    let share = |explained: f64| {
        let taken = explained / clean * after;
        taken / (before - after + taken)
    };
    let found = not_additive(context, chosen, lin).into_iter();
    let (worst, left) =
        found.map(|d| (d.remaining, share(d.explained))).max_by(|a, b| a.1.total_cmp(&b.1))?;
    // One effect that is not quite even is itself still, wherever it acts; of several, one that is not is a part.
    let most = match lin.layout.sigma_declared {
        true if different_names(context, chosen, lin) > 1 => 0.0,
        true => EXCESS_LEFT,
        false => EXCESS_LEFT_UNDECLARED,
    };
    (left >= most).then_some((worst, left))
}

/// A correction along a place, the time or the measured order that takes a visible share of the misfit beside several
/// names, or before any name: something that has no name, and names that may be parts of it.
fn parts_beside_correction(
    context: &Context<'_>,
    keep: &[bool],
    base: &Estimate,
    chosen: &Selected<'_>,
    lin: &Linear<'_>,
) -> Option<(Remaining, f64)> {
    let (found, is_before_names) = first_without_cause(context, chosen)?;
    let names = named(context, chosen, lin).count();
    if names == 0 {
        return None;
    }
    let alone = without_those(context, keep, chosen, |what| has_no_cause(context, what))?;
    let before = misfit(keep, &System::declared(context.model), base);
    let after = misfit(keep, &chosen.system, &chosen.estimate);
    let taken = (misfit(keep, &alone.system, &alone.estimate) - after) / (before - after);
    // What is corrected after the only name is a part of it, unless it is the larger one; beside different names, any.
    let least = match different_names(context, chosen, lin) {
        1 if names == 1 && !is_before_names => MOSTLY_LEFT,
        1 => EXCESS_LEFT,
        _ => f64::NEG_INFINITY,
    };
    (taken >= least).then_some((found, taken))
}

/// The first correction of no known cause, and whether it came before any name.
fn first_without_cause(context: &Context<'_>, chosen: &Selected<'_>) -> Option<(Remaining, bool)> {
    let index = chosen.added.iter().position(|added| has_no_cause(context, &added.what))?;
    let What::Empirical(covariate, shape) = &chosen.added[index].what else { return None };
    let shape = format!("{shape}, of no known cause, beside what was named");
    let p_value = chosen.added[index].p_value;
    Some((Remaining { covariate: covariate.clone(), shape, p_value }, index == 0))
}

/// Whether it is a correction along something that causes nothing: a temperature does.
fn has_no_cause(context: &Context<'_>, what: &What) -> bool {
    let What::Empirical(covariate, _) = what else { return false };
    let along = context.covariates.iter().find(|c| c.name == *covariate);
    along.is_some_and(|c| c.quantity != Quantity::Temperature)
}

/// Effects of many readings that have a name.
fn named<'a>(
    context: &'a Context<'_>,
    chosen: &'a Selected<'_>,
    lin: &'a Linear<'_>,
) -> impl Iterator<Item = usize> + 'a {
    let active = chosen.system.active.iter().map(|active| active.effect);
    active.filter(|&effect| home_of_bad(context, &chosen.estimate, lin, effect).is_none())
}

/// How many different ones there are among them.
fn different_names(context: &Context<'_>, chosen: &Selected<'_>, lin: &Linear<'_>) -> usize {
    let effects = &context.model.declared().effects;
    let ids = named(context, chosen, lin).map(|effect| &*effects[effect].id);
    ids.collect::<BTreeSet<&str>>().len()
}

/// What is left above the declared noise, structure where it has any, and its share of what was before.
fn left_above(
    context: &Context<'_>,
    keep: &[bool],
    (system, at): (&System<'_>, &Estimate),
    chosen: &Selected<'_>,
    lin: &Linear<'_>,
) -> Option<(Remaining, f64)> {
    let before = scatter(context, keep, system, at)?;
    let after = global_test(&chosen.system, &chosen.estimate, lin)?;
    let left = (after.per_dof() - 1.0) / (before.per_dof() - 1.0);
    let is_gross = after.per_dof() >= GROSS_STRUCTURE;
    let names = named(context, chosen, lin).count();
    let is_plain = is_gross || names > 1;
    // Accidents by the dozen beside ten times the noise are none, however large they are.
    let are_accidents = is_gross && many_bad_readings(context, chosen);
    let is_lost = are_accidents && after.per_dof() >= GROSS_SCATTER;
    // Of many, none is the last one.
    let are_many = names >= MANY_NAMES && different_names(context, chosen, lin) > 1;
    let least = match is_plain {
        _ if are_many => 0.0,
        true => STRUCTURE_LEFT,
        false => EXCESS_LEFT,
    };
    if !after.is_above() || left < least && !is_lost {
        return None;
    }
    let departures = plainly_not_additive(context, chosen, lin).into_iter().map(|d| d.remaining);
    let is_doubtful = chosen.added.iter().any(|added| added.p_value > BEYOND_DOUBT);
    let may_be_parts = left >= MOSTLY_LEFT || is_plain || is_doubtful;
    let other = may_be_parts.then(|| structured(context, chosen, lin));
    let found = departures.chain(other.into_iter().flatten());
    let worst = found.min_by(|a, b| a.p_value.total_cmp(&b.p_value)).or_else(|| {
        let corrected = || first_without_cause(context, chosen).map(|(remaining, _)| remaining);
        is_gross.then(corrected).flatten()
    });
    let formless = || Remaining {
        covariate: "noise".to_owned(),
        shape: "what was named leaves much of what exceeds the declared noise".to_owned(),
        p_value: after.p_value(),
    };
    // Beside noise several times as large as declared several names are parts of it, and a bad reading is one of many.
    let are_parts = match names {
        0 => left >= MOSTLY_LEFT,
        1 => {
            left >= EXCESS_LEFT && after.per_dof() >= GROSS_SCATTER
                || left >= EXCESS_LEFT_UNDECLARED && after.per_dof() >= LARGE_SCATTER
        }
        _ => true,
    };
    let is_any_enough =
        are_many || left >= HARDLY_EXPLAINED || is_gross && are_parts || are_accidents;
    worst.or_else(|| is_any_enough.then(formless)).map(|worst| (worst, left))
}

/// Sum of squared residuals over the uncertainties of their rows, without any scatter between
/// observations.
pub(crate) fn misfit(keep: &[bool], system: &System<'_>, at: &Estimate) -> f64 {
    let layout = &system.model.declared().layout;
    let all = system.residuals(at);
    rows_of(layout, keep).iter().map(|&row| (all[row] / layout.rows[row].sigma).powi(2)).sum()
}

fn scatter(
    context: &Context<'_>,
    keep: &[bool],
    system: &System<'_>,
    at: &Estimate,
) -> Option<GlobalTest> {
    global_test(system, at, &Linear::of(system, at, keep, context.silent))
}

/// The selection without every effect that has a name; `None` where that cannot be fitted.
pub(crate) fn without_names<'a>(
    context: &Context<'a>,
    keep: &[bool],
    chosen: &Selected<'a>,
) -> Option<Selected<'a>> {
    without_those(context, keep, chosen, |what| matches!(what, What::Effect(_)))
}

/// The selection without these additions; `None` where that cannot be fitted.
fn without_those<'a>(
    context: &Context<'a>,
    keep: &[bool],
    chosen: &Selected<'a>,
    is_out: impl Fn(&What) -> bool,
) -> Option<Selected<'a>> {
    let mut rest = chosen.clone();
    while let Some(index) = rest.added.iter().position(|added| is_out(&added.what)) {
        rest = without(context, keep, &rest, index)?;
    }
    Some(rest)
}
