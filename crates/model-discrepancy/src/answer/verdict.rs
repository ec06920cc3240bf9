//! The conclusion.

use crate::answer::estimate::too_noisy;
use crate::answer::external_validation::check_distance;
use crate::choice::context::Context;
use crate::choice::selected::Selected;
use crate::count::count;
use crate::noise::linear::Linear;
use crate::{Remaining, Role, Verdict};

pub(crate) fn verdict(
    context: &Context<'_>,
    lin: &Linear<'_>,
    chosen: &Selected<'_>,
    remaining: &[Remaining],
) -> Verdict {
    if !remaining.is_empty() || many_bad_readings(context, chosen) {
        return Verdict::StructureRemains;
    }
    if context.model.declared().layout.sigma_declared && noisier_than_declared(context, lin, chosen)
    {
        return Verdict::NoiseLargerThanDeclared;
    }
    if chosen.added.is_empty() { Verdict::NothingMissing } else { Verdict::Explained }
}

/// Whether fitted and check groups scatter more than declared.
fn noisier_than_declared(context: &Context<'_>, lin: &Linear<'_>, chosen: &Selected<'_>) -> bool {
    let dof = lin.rows.len().saturating_sub(chosen.system.dim());
    // Judged by what was declared, without any scatter that the loop has estimated.
    let declared = lin.rows.iter().zip(&lin.sigma).map(|(&row, s)| s / lin.layout.rows[row].sigma);
    let chi2: f64 = lin.residual.iter().zip(declared).map(|(r, ratio)| (r * ratio).powi(2)).sum();
    let (chi2, dof) = match check_distance(context, chosen, lin, &|row| row.sigma) {
        Some(check) => (chi2 + check.square, count(dof) + check.rows),
        None => (chi2, count(dof)),
    };
    dof > 0.0 && too_noisy(chi2, dof)
}

/// More single bad readings than two, and than one group in twenty, are no accidents.
fn many_bad_readings(context: &Context<'_>, chosen: &Selected<'_>) -> bool {
    let effects = &context.model.declared().effects;
    let bad = chosen.system.active.iter().filter(|a| effects[a.effect].subject.is_some()).count();
    let groups =
        context.model.declared().layout.groups.iter().filter(|g| g.role == Role::Fit).count();
    bad > 2.max(groups / 20)
}
