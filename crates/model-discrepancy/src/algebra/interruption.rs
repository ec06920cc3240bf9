//! A drift that breaks off and goes on elsewhere, found by looking for the place of the break.

use crate::algebra::drifts::Drifts;
use crate::count::count;
use crate::{Effect, Model, State};

/// Distinct times on either side of a break: a level and a slope, and as many again to judge them.
const MIN_SIDE: usize = 4;

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
        let each = |of: fn(f64) -> f64| elapsed.iter().map(|t| of(t - self.at)).collect();
        [elapsed.to_vec(), each(|since| f64::from(u8::from(since > 0.0))), each(|s| s.max(0.0))]
    }

    /// The effect for a drift that goes on evenly: its amplitudes of all courses, course by course.
    /// `place` says where the break is.
    #[must_use]
    pub fn effect(&self, even: &Effect, place: &str) -> Effect {
        let subject = even.subject.as_ref().map_or_else(String::new, |s| format!("{s}, "));
        let named = ["", " jump", " rate change"].into_iter().flat_map(|course| {
            even.parameters.iter().cloned().map(move |mut parameter| {
                parameter.name.push_str(course);
                parameter
            })
        });
        Effect {
            subject: Some(format!("{subject}interrupted")),
            description: format!(
                "{}, breaks off {place}, and goes on at another rate from another level",
                even.description
            ),
            parameters: named.collect(),
            searched: self.searched,
            ..even.clone()
        }
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
    let breaks = breaks(elapsed);
    let searched = breaks.len();
    let of_break = |at: f64| {
        let interruption = Interruption { at, searched };
        let course = |k: usize, t: f64| interruption.courses(&[t])[k][0];
        let left =
            drifts.left_along_each(&[&|t| course(0, t), &|t| course(1, t), &|t| course(2, t)]);
        Some((drifts.residual.explained(&left)?, interruption))
    };
    let evenly = drifts.residual.explained(&drifts.left_along(|t| t))?;
    let all = breaks.into_iter().filter_map(of_break);
    let (most, best) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let more = (COURSES - 1) * drifts.even.ncols();
    let p_value = drifts.residual.p_value_of_more(most - evenly, more, most) * count(searched);
    (p_value <= FALSE_ALARM).then_some(best)
}

/// One between each two successive times, with enough of them on either side.
fn breaks(elapsed: &[f64]) -> Vec<f64> {
    let mut distinct = elapsed.to_vec();
    distinct.sort_by(f64::total_cmp);
    distinct.dedup();
    let last = distinct.len().saturating_sub(MIN_SIDE);
    (MIN_SIDE..=last).map(|i| f64::midpoint(distinct[i - 1], distinct[i])).collect()
}
