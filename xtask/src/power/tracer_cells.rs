//! Situations of laser-tracer runs.

use super::cell::{Cell, Question, direction, sign};
use super::scene::{Scene, TIMES};
use super::tracer_design::run_at;
use crate::generators::Colour;
use crate::generators::tracer::Run;
use crate::generators::tracer_run::Defect;

/// Effects that share the level: half of it is the catalogue's, which holds 4 of the whole, 6 + 6
/// of stations, 24 jumps and 4 slips.
const CANDIDATES: usize = 88;

/// All cells of tracer-lm.
pub(super) fn cells() -> Vec<Cell> {
    use Question::{FalseAddition, Named};
    let mut cells = vec![
        cell("nothing, white noise", FalseAddition, |seed| Scene::Tracer(base(seed))),
        cell("nothing, white noise not declared", FalseAddition, |seed| {
            Scene::Tracer(Run { declare_noise: false, ..base(seed) })
        }),
        cell("nothing, AR(1) 0.7 from step to step", FalseAddition, |seed| {
            Scene::Tracer(Run { colour: Colour::Ar1(0.7), declare_noise: false, ..base(seed) })
        }),
        cell("nothing, 1/f from step to step", FalseAddition, |seed| {
            Scene::Tracer(Run { colour: Colour::Pink, declare_noise: false, ..base(seed) })
        }),
        cell("nothing, one reading in ten missing", FalseAddition, |seed| {
            Scene::Tracer(Run { missing: 0.1, record_air: true, ..base(seed) })
        }),
        cell("reading creeps after lock-on", Named("range-drift"), |seed| {
            let run = Run { one_tracer: true, ..base(seed) };
            with(&run, 1, |a, d| Defect::RangeDrift(a * sign(d)))
        }),
        cell("one stand drifts", Named("station-drift"), |seed| {
            with(&base(seed), 3, |a, d| Defect::StationDrift(2, d.map(|v| a * v)))
        }),
        cell("backlash", Named("backlash"), |seed| {
            let run = Run { both_ways: true, n_angles: 13, ..base(seed) };
            with(&run, 6, |a, d| Defect::Backlash(a * sign(d), d.map(|v| 50.0 * a * v)))
        }),
        cell("glass path of the reflectors", Named("incidence"), |seed| {
            with(&base(seed), 1, |a, d| Defect::Incidence(a * sign(d)))
        }),
        cell("one beam lost and found", Named("dead-path-jump"), |seed| {
            with(&base(seed), 1, |a, d| Defect::DeadPathJump(1, 2, 8, a * sign(d)))
        }),
        cell("one reflector slips", Named("mount-slip"), |seed| {
            with(&base(seed), 3, |a, d| Defect::MountSlip(1, 11, d.map(|v| a * v)))
        }),
        cell("wavelength follows the air", Named("temperature"), |seed| {
            let run = Run { record_air: true, ..base(seed) };
            with(&run, 1, |a, d| Defect::Temperature(a * sign(d)))
        }),
        cell("wrong wavelength, stations known to 0.5 µm", Named("range-scale"), |seed| {
            with(&known(seed), 1, |a, d| Defect::RangeScale(a * sign(d)))
        }),
        cell("one station reads long, all known to 0.5 µm", Named("bad-station"), |seed| {
            with(&known(seed), 1, |a, d| Defect::BadStation(4, a * sign(d)))
        }),
    ];
    cells.extend(beyond_one_name());
    cells
}

/// Two effects at once, and what no name fits.
fn beyond_one_name() -> Vec<Cell> {
    use Question::{BothNamed, ConfidentWrongName, OtherName};
    vec![
        cell(
            "one stand drifts, a beam is lost",
            BothNamed(["station-drift", "dead-path-jump"]),
            |seed| {
                let drift = sized(&base(seed), 3, |a, d| Defect::StationDrift(2, d.map(|v| a * v)));
                let jump = sized(&base(seed), 1, |a, d| Defect::DeadPathJump(4, 1, 8, a * sign(d)));
                both(&drift, &jump)
            },
        ),
        cell("glass path, a reflector slips", BothNamed(["incidence", "mount-slip"]), |seed| {
            let glass = sized(&base(seed), 1, |a, d| Defect::Incidence(a * sign(d)));
            let slip = sized(&base(seed), 3, |a, d| Defect::MountSlip(1, 11, d.map(|v| a * v)));
            both(&glass, &slip)
        }),
        cell("wrong wavelength, 60 ppm", OtherName("range-scale"), |seed| {
            Scene::Tracer(Run { defect: Defect::RangeScale(60e-6), ..base(seed) })
        }),
        cell("one station reads long, 20 ppm", OtherName("bad-station"), |seed| {
            Scene::Tracer(Run { defect: Defect::BadStation(4, 20e-6), ..base(seed) })
        }),
        cell("one bracket bends, 12 µm", ConfidentWrongName, |seed| {
            Scene::Tracer(Run { defect: Defect::Bending(3, 0.012), ..base(seed) })
        }),
    ]
}

fn cell(situation: &'static str, question: Question, make: fn(u64) -> Scene) -> Cell {
    Cell { krate: "tracker-lm", situation, question, make }
}

/// Six stations, four reflectors, nineteen angles.
fn base(seed: u64) -> Run {
    Run { n_angles: 19, ..Run::new(seed) }
}

/// The same with stations measured by something ten times as good.
fn known(seed: u64) -> Run {
    Run { stations_off_mm: 5e-4, ..base(seed) }
}

fn with(run: &Run, n_amplitudes: usize, defect: fn(f64, [f64; 3]) -> Defect) -> Scene {
    Scene::Tracer(sized(run, n_amplitudes, defect))
}

fn sized(run: &Run, n_amplitudes: usize, defect: fn(f64, [f64; 3]) -> Defect) -> Run {
    let d = direction(run.seed);
    run_at(run, |a| defect(a, d), n_amplitudes, CANDIDATES, TIMES)
}

/// The defects of both, which have the same seed, in one run.
fn both(first: &Run, second: &Run) -> Scene {
    Scene::Tracer(Run { second: second.defect, ..first.clone() })
}
