//! How a drift goes, where it does not go on evenly.

use nalgebra::Point3;

use crate::algebra::drifts::Drifts;
use crate::algebra::session::{Session, session_of};
use crate::algebra::settling::{Settling, settling_of};
use crate::{Effect, Model, State};

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

    fn at(&self, t: f64) -> f64 {
        match self {
            Self::Settling(settling) => settling.come(t),
            Self::Session(session) => session.come(t),
        }
    }

    /// The effect for the drift of a model that goes on evenly, an effect of its catalogue, and the time
    /// that had passed at each observation; its amplitudes, reported in a unit by a factor, are what it
    /// comes to in the end.
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
    let Some(drifts) = Drifts::of(model, at, drift, elapsed) else { return Vec::new() };
    let is_timed = model.declared().effects[drift].driver.is_some();
    let taken = |course: &Course| drifts.residual.explained(&drifts.left_along(|t| course.at(t)));
    let settling = settling_of(&drifts).map(Course::Settling);
    let session = session_of(&drifts)
        .filter(|s| is_timed || s.is_mixed(elapsed, places))
        .map(Course::Session)
        // Part of what comes to rest looks like a step.
        .filter(|session| taken(session) > settling.as_ref().and_then(taken));
    settling.into_iter().chain(session).collect()
}
