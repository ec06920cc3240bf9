//! Situations of points measured on a rotary axis.

use crate::kinds::tracker_lm::target_design::survey_at;
use crate::kinds::tracker_lm::targets::{Fault, Survey};
use crate::power::cell::{Cell, Question, direction, sign};
use crate::power::scene::{Scene, TIMES};

/// Effects that share the level: half of it is the catalogue's, which holds a scale and a
/// backlash, a drift and a scale of each of two trackers, and four motions of the second body.
const CANDIDATES: usize = 20;

/// All cells of tracer-lm on points.
pub(crate) fn cells() -> Vec<Cell> {
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
        cell("points, one stand is knocked", Named("station-shift"), |seed| {
            with(&Survey::new(seed), 6, |a, d| {
                Fault::Knocked(1, 6, d.map(|v| a * v), d.map(|v| 5e-4 * a * v))
            })
        }),
        cell("points, the machine is moved, there and back", Named("session-shift"), |seed| {
            let survey = Survey { both_ways: true, ..Survey::new(seed) };
            with(&survey, 6, |a, d| Fault::Moved(9, d.map(|v| a * v), d.map(|v| 1e-3 * a * v)))
        }),
        cell("points, perfect axis, nothing", FalseAddition, |seed| {
            Scene::Targets(Survey { mounts_off_mm: 0.3, ..perfect(seed) })
        }),
        cell("points, perfect axis from its place", Named("axis-location"), |seed| {
            let d = direction(seed);
            let tilt = [5e-4 * d[1], 0.0, 5e-4 * d[0]];
            let fault = Fault::AxisMoved(d.map(|v| 0.5 * v), tilt);
            Scene::Targets(Survey { fault, ..perfect(seed) })
        }),
        cell("points, perfect axis, EYB once per turn", Named("axial-motion"), |seed| {
            with(&perfect(seed), 4, |a, d| Fault::AxisMotion(1, 1, a, 3.0 * d[0]))
        }),
        cell("points, perfect axis, ECB twice per turn", Named("tilt-motion"), |seed| {
            with(&perfect(seed), 4, |a, d| Fault::AxisMotion(5, 2, 2e-3 * a, 3.0 * d[0]))
        }),
    ]
}

/// An axis without errors, which the case takes for perfect, with reflectors known to 10 µm.
fn perfect(seed: u64) -> Survey {
    Survey { perfect: true, mounts_off_mm: 0.01, n_angles: 19, ..Survey::new(seed) }
}

fn cell(situation: &'static str, question: Question, make: fn(u64) -> Scene) -> Cell {
    Cell { krate: "tracker-lm", situation, question, make }
}

fn with(survey: &Survey, n_amplitudes: usize, fault: fn(f64, [f64; 3]) -> Fault) -> Scene {
    let d = direction(survey.seed);
    Scene::Targets(survey_at(survey, |a| fault(a, d), n_amplitudes, CANDIDATES, TIMES))
}
