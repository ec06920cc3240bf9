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

/// Readings in a session that ends, at least: as many as before and after it together.
const FEWEST: usize = 8;

/// Share of what a session that ends takes that one reading may have: more is a reading far off and its neighbours.
const OF_ONE: f64 = 0.5;

/// Readings whose neighbours are looked for, at most.
const MOST_LOOKED_AT: usize = 400;

/// Times between which a session may begin and end, at most, to begin with: each is then looked for among all in between.
const MOST_WINDOWS: usize = 48;

/// Variances by which what a session that ends takes is more than what one that goes on does: of noise with a memory of a
/// few readings the mean of a stretch has six times the variance, and there are as many stretches as pairs of readings.
const CLEARLY_MORE: f64 = 50.0;

/// From when on, or from when to when, everything reads elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Session {
    /// Between the last reading before and the first after, in the unit in which time is counted.
    begins: f64,
    /// Between its last reading and the first after it; infinite where it goes on.
    ends: f64,
    searched: usize,
}

impl Session {
    /// From a time on.
    pub(crate) fn from(begins: f64) -> Self {
        Self { begins, ends: f64::INFINITY, searched: 1 }
    }

    /// Nought before it, one while it lasts.
    pub(crate) fn come(&self, t: f64) -> f64 {
        f64::from(u8::from(t > self.begins && t < self.ends))
    }

    /// The effect for a drift of the catalogue of a model, and the time that had passed at each
    /// observation.
    pub(crate) fn effect(&self, model: &dyn Model, drift: usize, elapsed: &[f64]) -> Effect {
        let even = &model.declared().effects[drift];
        let [first, last] = self.first_and_last(model, elapsed).unwrap_or_default();
        let goes_on = self.ends.is_infinite();
        let when =
            if goes_on { format!("from {first} on") } else { format!("from {first} to {last}") };
        let mut effect = along(even, &when, self.searched);
        "session-shift".clone_into(&mut effect.id);
        // What is looked for only instead says in its subject what it moves besides.
        let thing = even.subject.as_deref().filter(|_| !even.only_instead);
        let what = thing.unwrap_or("everything");
        effect.description = format!(
            "{what} reads elsewhere {when}: the part, the machine or the instrument was moved, or {}",
            if goes_on { "another session began" } else { "that was another session" }
        );
        effect
    }

    /// Whether both sessions read all over the place: else the step may as well be one from place to
    /// place. `places` are those of the observations, as far as they have one.
    pub(crate) fn is_mixed(&self, elapsed: &[f64], places: &[Option<Point3<f64>>]) -> bool {
        let come = |(t, place): (&f64, &Option<Point3<f64>>)| {
            Some((place.as_ref().copied()?, self.come(*t) > 0.0))
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

    /// Whether it ends again, but not within one group: of that, no other tells anything.
    pub(crate) fn comes_and_goes(&self, model: &dyn Model, elapsed: &[f64]) -> bool {
        self.ends.is_finite()
            && self.first_and_last(model, elapsed).is_some_and(|[first, last]| first != last)
    }

    /// Names of the groups of its first and its last observation.
    fn first_and_last(&self, model: &dyn Model, elapsed: &[f64]) -> Option<[String; 2]> {
        let layout = &model.declared().layout;
        let of_it =
            || elapsed.iter().zip(&layout.observations).filter(|(t, _)| self.come(**t) > 0.0);
        let first = of_it().min_by(|a, b| a.0.total_cmp(b.0))?;
        let last = of_it().max_by(|a, b| a.0.total_cmp(b.0))?;
        Some([first, last].map(|(_, &group)| layout.groups[group].name.clone()))
    }
}

/// The time from which on, or from which to which other, a shift by the amplitudes of a drift takes most of the residual,
/// where the chance that white noise beside the drift, going on evenly, shows one as clear is no more than `false_alarm`; one that
/// ends is looked for where it may be any, and must be one that may.
pub(crate) fn session_of(
    drifts: &Drifts<'_>,
    false_alarm: f64,
    may_end: Option<impl Fn(&Session) -> bool>,
) -> Option<Session> {
    let breaks = drifts.breaks();
    let searched = breaks.len();
    let of_break = |(begins, taken): (&f64, Option<f64>)| {
        Some((taken?, Session { begins: *begins, ends: f64::INFINITY, searched }))
    };
    let all = breaks.iter().zip(drifts.explained_by_shifts(&breaks)).filter_map(of_break);
    let (most, mut best) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
    if let Some(may_end) = may_end
        && let Some((taken, window)) = window_of(drifts, &breaks)
        && taken - most > CLEARLY_MORE * drifts.residual.variance_beside(taken, drifts.even.ncols())
        && may_end(&window)
        && drifts.most_of_one_reading(|t| window.come(t)) <= OF_ONE
    {
        best = window;
    }
    let evenly = drifts.residual.explained(&drifts.left_along(|t| t)).unwrap_or(0.0);
    let shift = |t: f64| best.come(t);
    let both = drifts.residual.explained(&drifts.left_along_each(&[&|t| t, &shift]))?;
    let beside = drifts.residual.p_value_of_more(both - evenly, drifts.even.ncols(), both);
    (beside * count(best.searched) <= false_alarm).then_some(best)
}

/// The session between two of some ascending times that takes most: first of a few of them, then of those beside.
fn window_of(drifts: &Drifts<'_>, breaks: &[f64]) -> Option<(f64, Session)> {
    let every = breaks.len().div_ceil(MOST_WINDOWS).max(1);
    let few: Vec<usize> = (0..breaks.len()).step_by(every).collect();
    let (mut most, [mut begins, mut ends]) = best_window(drifts, breaks, &few, &few)?;
    if every > 1 {
        let beside = |at: usize| -> Vec<usize> {
            (at.saturating_sub(every)..(at + every + 1).min(breaks.len())).collect()
        };
        if let Some(finer) = best_window(drifts, breaks, &beside(begins), &beside(ends)) {
            (most, [begins, ends]) = finer;
        }
    }
    let searched = breaks.len() * breaks.len().saturating_sub(1) / 2;
    Some((most, Session { begins: breaks[begins], ends: breaks[ends], searched }))
}

/// Which of some times it begins at, and at which it ends, with what it takes.
fn best_window(
    drifts: &Drifts<'_>,
    breaks: &[f64],
    begins: &[usize],
    ends: &[usize],
) -> Option<(f64, [usize; 2])> {
    let mut at: Vec<usize> = begins.iter().chain(ends).copied().collect();
    at.sort_unstable();
    at.dedup();
    let times: Vec<f64> = at.iter().map(|&at| breaks[at]).collect();
    let after = drifts.sums_after(&times);
    let sums = |of: usize| &after[at.partition_point(|known| *known < of)];
    let pairs = begins.iter().flat_map(|&b| ends.iter().map(move |&e| [b, e]));
    pairs
        .filter(|[b, e]| *e >= b + FEWEST)
        .filter_map(|[b, e]| Some((sums(b).less(sums(e)).explained()?, [b, e])))
        .max_by(|a, b| a.0.total_cmp(&b.0))
}
