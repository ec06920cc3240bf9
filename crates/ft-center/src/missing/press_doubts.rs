//! Records that do not show what the others show.

use model_discrepancy::Remaining;

use crate::{Orbit, SolvedPress};

/// Power, in units of the record's own noise, from which a circle could not have been missed: the
/// chance that noise alone rises as high is `exp(−25)`.
const CANNOT_BE_MISSED: f64 = 25.0;

/// Records without the spin that the others show, although their noise would not hide it.
///
/// A head that turns in every press turns in every record. Where the line is gone, something
/// between head and record swallows it: play, a clamped sensor, a filter.
pub(crate) fn lost_spin(presses: &[SolvedPress]) -> Option<Remaining> {
    let radii = presses.iter().filter_map(|p| p.orbit.wobble.map(|w| w.radius_mm));
    let mut radii: Vec<_> = radii.collect();
    radii.sort_by(f64::total_cmp);
    let radius_mm = *radii.get(radii.len() / 2)?;
    let expected = |orbit: &Orbit| {
        let noise_mm2 = orbit.scatter_mm2.trace();
        crate::count(orbit.contact_samples) * radius_mm * radius_mm / (2.0 * noise_mm2)
    };
    let still = presses.iter().filter(|p| p.orbit.wobble.is_none());
    let lost: Vec<_> =
        still.map(|p| expected(&p.orbit)).filter(|&e| e > CANNOT_BE_MISSED).collect();
    let least = lost.iter().copied().fold(f64::INFINITY, f64::min);
    (!lost.is_empty() && radii.len() >= lost.len()).then(|| Remaining {
        covariate: "spin".to_owned(),
        shape: format!("lost in {} of {} records", lost.len(), presses.len()),
        p_value: (-least).exp(),
    })
}
