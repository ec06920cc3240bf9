//! Situations of points measured on a rotary axis.

use super::cell::{Cell, Question, direction, sign};
use super::scene::{Scene, TIMES};
use super::target_design::survey_at;
use crate::generators::targets::{Fault, Survey};

/// Effects that share the level: half of it is the catalogue's, which holds a scale and a
/// backlash, a drift and a scale of each of two trackers, and four motions of the second body.
const CANDIDATES: usize = 20;

/// All cells of tracer-lm on points.
pub(super) fn cells() -> Vec<Cell> {
    use Question::{FalseAddition, Named};
    vec![
        cell("points, nothing", FalseAddition, |seed| Scene::Targets(Survey::new(seed))),
        cell("points, nothing, there and back", FalseAddition, |seed| {
            Scene::Targets(Survey { both_ways: true, ..Survey::new(seed) })
        }),
        cell("points, backlash", Named("backlash"), |seed| {
            let survey = Survey { both_ways: true, ..Survey::new(seed) };
            with(&survey, 6, |a, d| Fault::Backlash(2e-3 * a * sign(d), d.map(|v| a * v)))
        }),
        cell("points, a body gives under its weight", Named("body-sag"), |seed| {
            with(&Survey::new(seed), 3, |a, d| Fault::Flexure(a * sign(d)))
        }),
        cell("points, one stand gives way", Named("station-drift"), |seed| {
            // A slope in time from thirteen stops would itself cost a quarter of the noise.
            let survey = Survey { n_angles: 25, ..Survey::new(seed) };
            with(&survey, 6, |a, d| Fault::Stand(1, d.map(|v| a * v), d.map(|v| 5e-4 * a * v)))
        }),
    ]
}

fn cell(situation: &'static str, question: Question, make: fn(u64) -> Scene) -> Cell {
    Cell { krate: "tracker-lm", situation, question, make }
}

fn with(survey: &Survey, n_amplitudes: usize, fault: fn(f64, [f64; 3]) -> Fault) -> Scene {
    let d = direction(survey.seed);
    Scene::Targets(survey_at(survey, |a| fault(a, d), n_amplitudes, CANDIDATES, TIMES))
}
