//! How a drift goes, where it does not go on evenly.

use nalgebra::Point3;

use crate::algebra::drifts::Drifts;
use crate::algebra::looked_through::FALSE_ALARM;
use crate::algebra::session::{Session, session_of};
use crate::algebra::settling::{Rest, Settling};
use crate::algebra::settling_search::settling_of;
use crate::{Effect, Model, Role, State};

/// A course that the residual shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Course {
    /// Until it comes to rest.
    Settling(Settling),
    /// All at once.
    Session(Session),
}

impl Course {
    /// How far it has come at each time since the start.
    #[must_use]
    pub fn come(&self, elapsed: &[f64]) -> Vec<f64> {
        elapsed.iter().map(|t| self.at(*t)).collect()
    }

    /// What comes to rest away from where it was declared, from what it was at first to that, or the other way.
    #[must_use]
    pub fn the_other_way(&self) -> Option<Self> {
        match self {
            Self::Settling(settling) => Some(Self::Settling(settling.the_other_way())),
            Self::Session(_) => None,
        }
    }

    /// When its amplitudes are seen in full.
    #[must_use]
    pub fn seen_in_full(&self) -> &'static str {
        match self {
            Self::Settling(settling) if settling.goes_both_ways() => "both ways together",
            Self::Settling(settling) if settling.rests_as_declared() => "at first",
            _ => "in the end",
        }
    }

    fn at(&self, t: f64) -> f64 {
        match self {
            Self::Settling(settling) => settling.come(t),
            Self::Session(session) => session.come(t),
        }
    }

    /// Whether another is the same but for the last digits of its time constants.
    #[must_use]
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Settling(one), Self::Settling(other)) => one.is_like(other, APART),
            (one, other) => one == other,
        }
    }

    /// The effect for the drift of a model that goes on evenly, an effect of its catalogue, and the time
    /// that had passed at each observation; its amplitudes, reported in a unit by a factor, are what it
    /// comes to in the end, or what it was at first.
    #[must_use]
    pub fn effect(
        &self,
        model: &dyn Model,
        drift: usize,
        elapsed: &[f64],
        time_unit: &str,
        (unit, factor): (&str, f64),
    ) -> Effect {
        let mut effect = match self {
            Self::Settling(settling) => settling.effect(model, drift, elapsed, time_unit),
            Self::Session(session) => session.effect(model, drift, elapsed),
        };
        for parameter in &mut effect.parameters {
            unit.clone_into(&mut parameter.unit);
            parameter.report_factor = factor;
        }
        effect
    }
}

/// How much another time constant has to be, for courses to be two.
const APART: f64 = 1.1;

/// The courses other than an even one along which a drift takes most of the residual of a model at
/// `at`, a solution of its declared part, or of that and the effects that `at` has, each where white
/// noise hardly ever shows one as clear.
///
/// `drift` is the effect that goes on evenly, `elapsed` what its amplitudes are multiplied by: the
/// time since the start of the series, one value per observation. Rows of a table without times may be
/// sorted by place: where no column drives the drift, a session is one only where its readings lie
/// among the others; `places` has the place of each observation, as far as there is one.
#[must_use]
pub fn clearest_courses(
    model: &dyn Model,
    at: &State,
    drift: usize,
    elapsed: &[f64],
    places: &[Option<Point3<f64>>],
) -> Vec<Course> {
    let clear = Sharpness { false_alarm: FALSE_ALARM, best_alone: true };
    courses(model, at, (drift, elapsed), places, clear)
}

/// The likeliest course that comes to rest, and the likeliest session, whether they are clear or not:
/// rivals of a drift that was found.
#[must_use]
pub(crate) fn likeliest_courses(
    model: &dyn Model,
    at: &State,
    drift: usize,
    elapsed: &[f64],
    places: &[Option<Point3<f64>>],
) -> Vec<Course> {
    let any = Sharpness { false_alarm: f64::INFINITY, best_alone: false };
    courses(model, at, (drift, elapsed), places, any)
}

/// Parts of a series before and after which it must have been all over the place.
const QUARTERS: [f64; 3] = [0.25, 0.5, 0.75];

/// Which courses are shown.
#[derive(Clone, Copy)]
struct Sharpness {
    /// Chance that white noise shows one as clear, at most.
    false_alarm: f64,
    /// Whether a session that takes less than an even drift, or than what comes to rest, is left out:
    /// part of those looks like a step.
    best_alone: bool,
}

fn courses(
    model: &dyn Model,
    at: &State,
    (drift, elapsed): (usize, &[f64]),
    places: &[Option<Point3<f64>>],
    sharpness: Sharpness,
) -> Vec<Course> {
    let Some(drifts) = Drifts::of(model, at, drift, elapsed) else { return Vec::new() };
    let Sharpness { false_alarm, best_alone } = sharpness;
    let even = &model.declared().effects[drift];
    let is_timed = even.driver.is_some();
    let taken = |course: &dyn Fn(f64) -> f64| drifts.residual.explained(&drifts.left_along(course));
    // Amplitudes that hardly show, and a time constant, fit whatever a few first readings do together.
    let rests: &[Rest] = if even.only_instead {
        &[]
    } else if drifts.has_zero_of_its_own() {
        &[Rest::Away]
    } else {
        &[Rest::Away, Rest::AsDeclared]
    };
    // What goes one way and comes back may be a hump of what was measured, where time and place go together, or no place
    // is known.
    let fitted = of_fitted(model, places);
    let is_mixed = |part: &f64| Session::from(part * drifts.span()).is_mixed(elapsed, &fitted);
    let may_go_both_ways = !places.is_empty() && QUARTERS.iter().all(is_mixed);
    let asked = (false_alarm, may_go_both_ways);
    let settling = rests.iter().filter_map(|rest| settling_of(&drifts, *rest, asked));
    let settling = settling.reduce(|a, b| drifts.likelier(a, b)).map(Course::Settling);
    let others = [taken(&|t| t), settling.as_ref().and_then(|course| taken(&|t| course.at(t)))];
    let is_best = |course: &Course| others.iter().all(|other| taken(&|t| course.at(t)) > *other);
    // What comes and goes may be a part of what was measured wherever its readings do not lie among the others.
    let may_end = (!places.is_empty()).then_some(|session: &Session| {
        session.is_mixed(elapsed, places) && session.comes_and_goes(model, elapsed)
    });
    let session = session_of(&drifts, false_alarm, may_end)
        .filter(|s| is_timed || s.is_mixed(elapsed, places))
        .map(Course::Session)
        .filter(|session| !best_alone || is_best(session));
    settling.into_iter().chain(session).collect()
}

/// The places of the observations that are fitted.
fn of_fitted(model: &dyn Model, places: &[Option<Point3<f64>>]) -> Vec<Option<Point3<f64>>> {
    let layout = &model.declared().layout;
    let is_fitted = |group: usize| layout.groups[group].role == Role::Fit;
    let groups = layout.observations.iter();
    groups.zip(places).map(|(group, place)| place.filter(|_| is_fitted(*group))).collect()
}
