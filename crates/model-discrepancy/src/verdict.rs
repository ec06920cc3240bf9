//! The conclusion.

use crate::global_test::{GlobalTest, global_test};
use crate::judge::Setting;
use crate::linear::Linear;
use crate::select::Selected;
use crate::unforeseen::check_distance;
use crate::{Remaining, Role, Verdict};

pub(crate) fn verdict(
    setting: &Setting<'_>,
    lin: &Linear<'_>,
    chosen: &Selected<'_>,
    remaining: &[Remaining],
) -> Verdict {
    if !remaining.is_empty() || many_bad_readings(setting, chosen) {
        return Verdict::StructureRemains;
    }
    if noisier_than_declared(setting, lin, chosen) {
        return Verdict::NoiseLargerThanDeclared;
    }
    if chosen.added.is_empty() { Verdict::NothingMissing } else { Verdict::Explained }
}

/// Whether fitted groups, or these and the check groups together, scatter more than declared.
fn noisier_than_declared(setting: &Setting<'_>, lin: &Linear<'_>, chosen: &Selected<'_>) -> bool {
    let Some(fitted) = global_test(&chosen.system, &chosen.estimate, lin) else { return false };
    let with_check = check_distance(setting, chosen, lin, &|row| row.sigma).is_some_and(|check| {
        GlobalTest { chi2: fitted.chi2 + check.square, dof: fitted.dof + check.rows, ..fitted }
            .is_above()
    });
    fitted.is_above() || with_check
}

/// More single bad readings than two, and than one group in twenty, are no accidents.
fn many_bad_readings(setting: &Setting<'_>, chosen: &Selected<'_>) -> bool {
    let effects = &setting.model.declared().effects;
    let bad = chosen.system.active.iter().filter(|a| effects[a.effect].subject.is_some()).count();
    let groups =
        setting.model.declared().layout.groups.iter().filter(|g| g.role == Role::Fit).count();
    bad > 2.max(groups / 20)
}
