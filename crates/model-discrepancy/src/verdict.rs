//! The conclusion.

use crate::estimate::too_noisy;
use crate::judge::Setting;
use crate::linear::Linear;
use crate::select::Selected;
use crate::significance::count;
use crate::{Remaining, Verdict};

pub(crate) fn verdict(
    setting: &Setting<'_>,
    lin: &Linear<'_>,
    chosen: &Selected<'_>,
    remaining: &[Remaining],
) -> Verdict {
    if !remaining.is_empty() {
        return Verdict::StructureRemains;
    }
    let dof = lin.rows.len().saturating_sub(chosen.system.dim());
    let chi2 = lin.residual.norm_squared();
    if setting.model.layout().sigma_declared && dof > 0 && too_noisy(chi2, count(dof)) {
        return Verdict::NoiseLargerThanDeclared;
    }
    if chosen.added.is_empty() { Verdict::NothingMissing } else { Verdict::Explained }
}
