//! Situations of laser-tracer runs.

use crate::generators::Colour;
use crate::kinds::tracker_lm::tracer::Run;
use crate::kinds::tracker_lm::tracer_design::run_at;
use crate::kinds::tracker_lm::tracer_run::Defect;
use crate::power::cell::{Cell, Question, direction, sign};
use crate::power::scene::{Scene, TIMES};

/// Effects that share the level: half of it is the catalogue's, which holds 5 of the whole, 6 + 6
/// of stations, 24 jumps and 4 slips.
const CANDIDATES: usize = 90;

/// All cells of tracer-lm.
pub(crate) fn cells() -> Vec<Cell> {
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
        cell("the laser warms up", Named("scale-drift"), |seed| {
            with(&base(seed), 2, |a, d| Defect::Warming(a * sign(d), 1.0))
        }),
        cell("the laser comes to its temperature", Named("scale-drift"), |seed| {
            with(&base(seed), 2, |a, d| Defect::Warming(a * sign(d), 0.2))
        }),
        cell("reading creeps after lock-on", Named("range-drift"), |seed| {
            let run = Run { one_tracer: true, ..base(seed) };
            with(&run, 1, |a, d| Defect::RangeDrift(a * sign(d)))
        }),
        cell("the tracer at one station creeps", Named("range-drift"), |seed| {
            with(&base(seed), 1, |a, d| Defect::Creep(2, a * sign(d)))
        }),
        cell("one stand drifts", Named("station-drift"), |seed| {
            with(&base(seed), 3, |a, d| Defect::StationDrift(2, d.map(|v| a * v)))
        }),
        cell("one stand drifts, one tracer at all", Named("station-drift"), |seed| {
            let run = Run { one_tracer: true, ..base(seed) };
            with(&run, 3, |a, d| Defect::StationDrift(2, d.map(|v| a * v)))
        }),
        cell("one stand is knocked", Named("station-shift"), |seed| {
            with(&base(seed), 3, |a, d| Defect::Knocked(2, 8, d.map(|v| a * v)))
        }),
        cell("the machine is moved, there and back", Named("session-shift"), |seed| {
            let run = Run { both_ways: true, n_angles: 13, ..base(seed) };
            with(&run, 6, |a, d| {
                Defect::Moved(
                    9,
                    d.map(|v| a * v),
                    [1e-3 * a * d[1], 1e-3 * a * d[2], 1e-3 * a * d[0]],
                )
            })
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
            with(&run, 1, |a, d| Defect::Wavelength(a * sign(d)))
        }),
        cell("wrong wavelength, stations known to 0.5 µm", Named("range-scale"), |seed| {
            with(&known(seed), 1, |a, d| Defect::RangeScale(a * sign(d)))
        }),
        cell("one station reads long, all known to 0.5 µm", Named("bad-station"), |seed| {
            with(&known(seed), 1, |a, d| Defect::BadStation(4, a * sign(d)))
        }),
    ];
    cells.extend(beyond_one_name());
    cells.extend(perfect_axis());
    cells
}

/// The declared axis is perfect: what is missing is its place, or a motion error.
fn perfect_axis() -> Vec<Cell> {
    use Question::{BothNamed, FalseAddition, Named};
    vec![
        cell("perfect axis, nothing", FalseAddition, |seed| Scene::Tracer(perfect(seed))),
        cell("perfect axis, nothing, there and back", FalseAddition, |seed| {
            Scene::Tracer(Run { both_ways: true, n_angles: 13, ..perfect(seed) })
        }),
        cell("perfect axis, 0.5 mm and 0.5 mrad from its place", Named("axis-location"), |seed| {
            let d = direction(seed);
            let defect = Defect::AxisMoved(d.map(|v| 0.5 * v), [5e-4 * d[1], 0.0, 5e-4 * d[0]]);
            Scene::Tracer(Run { defect, ..perfect(seed) })
        }),
        cell("perfect axis, EXB twice per turn", Named("radial-motion"), |seed| {
            with(&perfect(seed), 4, |a, d| Defect::AxisMotion(0, 2, a, 3.0 * d[0]))
        }),
        cell("perfect axis, EYB once per turn", Named("axial-motion"), |seed| {
            with(&perfect(seed), 4, |a, d| Defect::AxisMotion(1, 1, a, 3.0 * d[0]))
        }),
        cell("perfect axis, EBB once per turn", Named("angular-positioning"), |seed| {
            with(&perfect(seed), 4, |a, d| Defect::AxisMotion(4, 1, a, 3.0 * d[0]))
        }),
        cell("perfect axis, ECB three times per turn", Named("tilt-motion"), |seed| {
            with(&perfect(seed), 6, |a, d| Defect::AxisMotion(5, 3, a, 3.0 * d[0]))
        }),
        cell(
            "perfect axis, from its place and EBB",
            BothNamed(["axis-location", "angular-positioning"]),
            |seed| {
                let d = direction(seed);
                let second = Defect::AxisMoved(d.map(|v| 0.2 * v), [2e-4 * d[1], 0.0, 2e-4 * d[0]]);
                let run = sized(&perfect(seed), 4, |a, d| Defect::AxisMotion(4, 2, a, 3.0 * d[0]));
                Scene::Tracer(Run { second, ..run })
            },
        ),
    ]
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

/// The same of an axis without errors, which the case takes for perfect.
fn perfect(seed: u64) -> Run {
    Run { perfect: true, ..base(seed) }
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
