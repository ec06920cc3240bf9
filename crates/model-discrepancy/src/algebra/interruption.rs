//! A drift that breaks off and goes on elsewhere, found by looking for the place of the break.

use crate::algebra::drifts::{Drifts, along};
use crate::count::count;
use crate::{Effect, Model, State};

/// Chance that readings without a break offer one: a tenth of what other drifts are allowed, for level
/// and rate on either side fit whatever a few last readings do together.
const FALSE_ALARM: f64 = 0.001;

/// Courses of an interrupted drift: what goes on, the jump, and what goes on after it besides.
const COURSES: usize = 3;

/// A drift that goes on evenly, jumps, and goes on evenly at another rate: the machine stood still
/// between two readings, was switched off, or something slipped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interruption {
    /// Between two successive times, in the unit in which time is counted.
    at: f64,
    searched: usize,
}

impl Interruption {
    /// What each of the three courses comes to at each time since the start: the time itself, 1 after
    /// the break, and the time since the break.
    #[must_use]
    pub fn courses(&self, elapsed: &[f64]) -> [Vec<f64>; COURSES] {
        std::array::from_fn(|k| elapsed.iter().map(|t| self.come(*t)[k]).collect())
    }

    fn come(&self, t: f64) -> [f64; COURSES] {
        [t, f64::from(u8::from(t > self.at)), (t - self.at).max(0.0)]
    }

    /// The effect for a drift that goes on evenly: its amplitudes of all courses, course by course.
    /// `place` says where the break is.
    #[must_use]
    pub fn effect(&self, even: &Effect, place: &str) -> Effect {
        let mut effect = along(even, "interrupted", self.searched);
        let named = ["", " jump", " rate change"].into_iter().flat_map(|course| {
            even.parameters.iter().cloned().map(move |mut parameter| {
                parameter.name.push_str(course);
                parameter
            })
        });
        effect.parameters = named.collect();
        effect.description = format!(
            "{}, breaks off {place}, and goes on at another rate from another level",
            even.description
        );
        effect
    }

    /// The last time before the break and the first one after it, as indices into the times.
    #[must_use]
    pub fn between(&self, elapsed: &[f64]) -> Option<(usize, usize)> {
        let times = || elapsed.iter().enumerate();
        let last = times().filter(|(_, t)| **t < self.at).max_by(|a, b| a.1.total_cmp(b.1))?.0;
        let next = times().filter(|(_, t)| **t > self.at).min_by(|a, b| a.1.total_cmp(b.1))?.0;
        Some((last, next))
    }
}

/// The break with which a drift takes most of the residual of a model at `at`, a solution of its
/// declared part; `None` where white noise might show one as clear beside a drift that goes on evenly.
///
/// `drift` is the effect that goes on evenly, `elapsed` what its amplitudes are multiplied by: the
/// time since the start of the series, one value per observation.
#[must_use]
pub fn clearest_interruption(
    model: &dyn Model,
    at: &State,
    drift: usize,
    elapsed: &[f64],
) -> Option<Interruption> {
    let drifts = Drifts::of(model, at, drift, elapsed)?;
    let breaks = drifts.breaks();
    let searched = breaks.len();
    let of_break = |at: f64| {
        let interruption = Interruption { at, searched };
        let course = |k: usize| move |t: f64| interruption.come(t)[k];
        let left = drifts.left_along_each(&[&course(0), &course(1), &course(2)]);
        Some((drifts.residual.explained(&left)?, interruption))
    };
    let evenly = drifts.residual.explained(&drifts.left_along(|t| t))?;
    let all = breaks.into_iter().filter_map(of_break);
    let (most, best) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let more = (COURSES - 1) * drifts.even.ncols();
    let p_value = drifts.residual.p_value_of_more(most - evenly, more, most) * count(searched);
    (p_value <= FALSE_ALARM).then_some(best)
}
