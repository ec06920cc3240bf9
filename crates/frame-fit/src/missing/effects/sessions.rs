//! One session that was not like the others.

use model_discrepancy::Covariate;

use nalgebra::SVector;

use super::{AXES, Entry, SESSION, entry, expansion, parameter, per_axis};
use crate::MeasuredPoint;
use crate::Transform;
use crate::missing::term::{BodyMotion, Term};
use crate::motion::axis_pairs;
use crate::statistics::ratio;

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
            let mut set_up = set_up_anew(name, points, &column.values);
            for (entry, more) in [(&mut warm, ""), (&mut moved, ""), (&mut set_up, ", and turned")]
            {
                entry.effect.subject = Some(format!("{name}{more}"));
            }
            [warm, moved, set_up]
        })
        .collect()
}

/// A session before which the part was set up anew: shifted and turned as a whole.
fn set_up_anew<const D: usize>(
    name: &str,
    points: &[MeasuredPoint<D>],
    inside: &[f64],
) -> Entry<D> {
    let is_inside = |size: &f64| (*size > 0.0).then_some(0);
    let body: Vec<Option<usize>> = inside.iter().map(is_inside).collect();
    let of_it = || points.iter().zip(&body).filter(|(_, body)| body.is_some());
    let sum = of_it().fold(SVector::zeros(), |sum, (p, _)| sum + p.pair.source_mm.coords);
    let motion = BodyMotion {
        pivots_mm: vec![sum / ratio(of_it().count().max(1))],
        body,
        still: "the other sessions".to_owned(),
    };
    let mut parameters = per_axis::<D>("mm", 1.0);
    parameters.extend(
        axis_pairs(D).map(|(a, b)| parameter(format!("{} to {}", AXES[a], AXES[b]), "µrad", 1e6)),
    );
    let text = format!(
        "the part was set up anew for {name}: shifted and turned against the others, in the source frame, about the \
         middle of its points"
    );
    entry("session-shift", &text, parameters, Term::BodyMotion(motion))
}
