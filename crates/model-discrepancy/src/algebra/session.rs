//! A reading, a part or an instrument that stands elsewhere from some time on: another session that no
//! column says.

use crate::algebra::drifts::{Drifts, along};
use crate::algebra::looked_through::FALSE_ALARM;
use crate::count::count;
use crate::{Effect, Model};

/// Observations before and after it, at least: fewer are readings far off, which have a name of their
/// own.
const MIN_SIDE: usize = 4;

/// From when on everything reads elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Session {
    /// Between the last reading before and the first after, in the unit in which time is counted.
    begins: f64,
    searched: usize,
}

impl Session {
    /// Nought before it and one from then on.
    #[must_use]
    pub fn course(&self, elapsed: &[f64]) -> Vec<f64> {
        elapsed.iter().map(|t| f64::from(u8::from(*t > self.begins))).collect()
    }

    /// The effect for a drift of the catalogue of a model, and the time that had passed at each
    /// observation; its amplitudes are reported in a unit by a factor.
    #[must_use]
    pub fn effect(
        &self,
        model: &dyn Model,
        drift: usize,
        elapsed: &[f64],
        reported: (&str, f64),
    ) -> Effect {
        let even = &model.declared().effects[drift];
        let mut effect = along(even, self.searched, reported);
        let first = self.first(model, elapsed).unwrap_or_default();
        "session-shift".clone_into(&mut effect.id);
        effect.subject = Some(format!("from {first} on"));
        effect.description = format!(
            "everything reads elsewhere from {first} on: the part, the machine or the instrument was \
             moved, or another session began"
        );
        effect
    }

    /// Name of the first observation of it.
    fn first(&self, model: &dyn Model, elapsed: &[f64]) -> Option<String> {
        let layout = &model.declared().layout;
        let after = elapsed.iter().zip(&layout.observations).filter(|(t, _)| **t > self.begins);
        let (_, &group) = after.min_by(|a, b| a.0.total_cmp(b.0))?;
        Some(layout.groups[group].name.clone())
    }
}

/// The time from which on a shift by the amplitudes of a drift takes most of the residual, where the
/// drift, going on evenly, takes less, and white noise beside it hardly ever shows one as clear.
pub(crate) fn session_of(drifts: &Drifts<'_>) -> Option<Session> {
    let times = drifts.times();
    let last = times.len().checked_sub(MIN_SIDE)?;
    let breaks: Vec<f64> = (MIN_SIDE..=last)
        .filter(|&first| times[first - 1] < times[first])
        .map(|first| f64::midpoint(times[first - 1], times[first]))
        .collect();
    let searched = breaks.len();
    let taken = |course: &dyn Fn(f64) -> f64| drifts.residual.explained(&drifts.left_along(course));
    let of_break = |begins: f64| {
        let session = Session { begins, searched };
        Some((taken(&|t| session.course(&[t])[0])?, session))
    };
    let all = breaks.into_iter().filter_map(of_break);
    let (most, best) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let evenly = taken(&|t| t).unwrap_or(0.0);
    let shift = |t: f64| best.course(&[t])[0];
    let both = drifts.residual.explained(&drifts.left_along_each(&[&|t| t, &shift]))?;
    let beside = drifts.residual.p_value_of_more(both - evenly, drifts.even.ncols(), both);
    (most > evenly && beside * count(searched) <= FALSE_ALARM).then_some(best)
}
