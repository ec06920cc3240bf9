//! One session that was not like the others.

use model_discrepancy::Covariate;

use super::{Entry, SESSION, entry, expansion, parameter, per_axis};
use crate::MeasuredPoint;
use crate::Transform;
use crate::missing::term::Term;

/// Fewest points of a session that say more than that each of them is off.
const FEWEST: f64 = 3.0;

/// For each session: a temperature that nobody recorded, and a frame that was set up anew.
pub(super) fn sessions<const D: usize>(
    transform: Transform,
    points: &[MeasuredPoint<D>],
    covariates: &[Covariate],
) -> Vec<Entry<D>> {
    let columns = covariates.iter().filter_map(|c| Some((c.name.strip_prefix(SESSION)?, c)));
    columns
        .filter(|(_, column)| column.values.iter().sum::<f64>() >= FEWEST)
        .flat_map(|(name, column)| {
            let text = format!(
                "the points of {name} were measured warmer or colder than the others, by a \
                 temperature that was not recorded"
            );
            let term = expansion(transform, points, column.values.clone());
            let growth = vec![parameter("growth", "ppm", 1e6)];
            let mut warm = entry("session-temperature", &text, growth, term);
            let text = format!("the target frame of {name} is shifted against that of the others");
            let term = Term::SessionShift { inside: column.values.clone() };
            let mut moved = entry("session-shift", &text, per_axis::<D>("mm", 1.0), term);
            for entry in [&mut warm, &mut moved] {
                entry.effect.subject = Some(name.to_owned());
            }
            [warm, moved]
        })
        .collect()
}
