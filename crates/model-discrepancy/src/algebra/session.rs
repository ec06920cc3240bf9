//! A reading, a part or an instrument that stands elsewhere from some time on: another session that no
//! column says.

use nalgebra::Point3;

use crate::algebra::drifts::{Drifts, along};
use crate::count::count;
use crate::{Effect, Model};

/// Readings whose nearest neighbour was read in the other session, at least, over how many there are
/// where order and place have nothing to do with each other: with fewer, what stands elsewhere is a
/// part of what was measured.
const LEAST_MIXED: f64 = 0.5;

/// Readings whose neighbours are looked for, at most.
const MOST_LOOKED_AT: usize = 400;

/// From when on everything reads elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Session {
    /// Between the last reading before and the first after, in the unit in which time is counted.
    begins: f64,
    searched: usize,
}

impl Session {
    /// Nought before it and one from then on.
    pub(crate) fn come(&self, t: f64) -> f64 {
        f64::from(u8::from(t > self.begins))
    }

    /// The effect for a drift of the catalogue of a model, and the time that had passed at each
    /// observation.
    pub(crate) fn effect(&self, model: &dyn Model, drift: usize, elapsed: &[f64]) -> Effect {
        let even = &model.declared().effects[drift];
        let first = self.first(model, elapsed).unwrap_or_default();
        let mut effect = along(even, &format!("from {first} on"), self.searched);
        "session-shift".clone_into(&mut effect.id);
        // What is looked for only instead says in its subject what it moves besides.
        let thing = even.subject.as_deref().filter(|_| !even.only_instead);
        let what = thing.unwrap_or("everything");
        effect.description = format!(
            "{what} reads elsewhere from {first} on: the part, the machine or the instrument was \
             moved, or another session began"
        );
        effect
    }

    /// Whether both sessions read all over the place: else the step may as well be one from place to
    /// place. `places` are those of the observations, as far as they have one.
    pub(crate) fn is_mixed(&self, elapsed: &[f64], places: &[Option<Point3<f64>>]) -> bool {
        let come = |(t, place): (&f64, &Option<Point3<f64>>)| {
            Some((place.as_ref().copied()?, *t > self.begins))
        };
        let all: Vec<(Point3<f64>, bool)> = elapsed.iter().zip(places).filter_map(come).collect();
        let later = count(all.iter().filter(|(_, later)| *later).count()) / count(all.len().max(1));
        let every = all.len().div_ceil(MOST_LOOKED_AT).max(1);
        let is_among = |&(i, (place, later)): &(usize, &(Point3<f64>, bool))| {
            let others = all.iter().enumerate().filter(|(other, _)| *other != i);
            let near = |(_, (at, _)): &(usize, &(Point3<f64>, bool))| (at - place).norm_squared();
            let nearest = others.min_by(|a, b| near(a).total_cmp(&near(b)));
            nearest.is_some_and(|(_, (_, other))| other != later)
        };
        let looked_at = || all.iter().enumerate().step_by(every);
        let among = count(looked_at().filter(is_among).count());
        among >= LEAST_MIXED * 2.0 * later * (1.0 - later) * count(looked_at().count())
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
/// chance that white noise beside the drift, going on evenly, shows one as clear is no more than
/// `false_alarm`.
pub(crate) fn session_of(drifts: &Drifts<'_>, false_alarm: f64) -> Option<Session> {
    let breaks = drifts.breaks();
    let searched = breaks.len();
    let of_break = |(begins, taken): (&f64, Option<f64>)| {
        Some((taken?, Session { begins: *begins, searched }))
    };
    let all = breaks.iter().zip(drifts.explained_by_shifts(&breaks)).filter_map(of_break);
    let (_, best) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let evenly = drifts.residual.explained(&drifts.left_along(|t| t)).unwrap_or(0.0);
    let shift = |t: f64| best.come(t);
    let both = drifts.residual.explained(&drifts.left_along_each(&[&|t| t, &shift]))?;
    let beside = drifts.residual.p_value_of_more(both - evenly, drifts.even.ncols(), both);
    (beside * count(searched) <= false_alarm).then_some(best)
}
