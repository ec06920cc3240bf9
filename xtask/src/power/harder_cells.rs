//! What simulators like those of the other cells do not bring: single readings far off, places that
//! come again, mistakes of one session, and physics of which no catalogue has the name.

use crate::generators::Colour;
use crate::kinds::force_impedance::polish::{self, Run};
use crate::kinds::frame_fit::survey::{Defect, Survey};
use crate::kinds::ft_center::press::{Fault, Session};
use crate::kinds::pose_icp::mirror::{self, Mirror};
use crate::kinds::positioning::positions::Positions;
use crate::kinds::probe_comp::probe;
use crate::kinds::tracker_lm::tracer;
use crate::kinds::tracker_lm::tracer_run;
use crate::power::cell::{Cell, Question, direction, sign};
use crate::power::scene::Scene;

/// All of them.
pub(crate) fn cells() -> Vec<Cell> {
    let mut cells = tails();
    cells.extend(repeats());
    cells.extend(outside());
    cells
}

const TAILS: &str = "heavy tails";
const REPEATS: &str = "repeated places";
const OUTSIDE: &str = "outside the catalogue";
/// By itself: a loop takes some ten seconds.
const OUTSIDE_TRACKER: &str = "outside the catalogue, rotary axes";

fn cell(
    krate: &'static str,
    situation: &'static str,
    question: Question,
    make: fn(u64) -> Scene,
) -> Cell {
    Cell { krate, situation, question, make }
}

/// Student's t with three degrees of freedom, nothing missing.
fn tails() -> Vec<Cell> {
    use Question::FalseAddition;
    vec![
        cell(TAILS, "frame-fit", FalseAddition, |seed| {
            let colour = Colour::HeavyTails;
            Scene::Survey(Survey { colour, n_fit: 40, ..Survey::new(seed) })
        }),
        cell(TAILS, "ft-center, the head's seat", FalseAddition, |seed| {
            let seat = Colour::HeavyTails;
            Scene::Session(Session { seat, colour: seat, ..Session::new(seed) })
        }),
        cell(TAILS, "force-impedance", FalseAddition, |seed| {
            Scene::Run(Run { colour: Colour::HeavyTails, ..Run::new(seed) })
        }),
        cell(TAILS, "pose-icp", FalseAddition, |seed| {
            Scene::Mirror(Mirror { colour: Colour::HeavyTails, ..Mirror::new(seed) })
        }),
        cell(TAILS, "probe-comp", FalseAddition, |seed| {
            let colour = Colour::HeavyTails;
            Scene::Probe(probe::Session { colour, ..probe::Session::new(seed) })
        }),
        cell(TAILS, "tracker-lm", FalseAddition, |seed| {
            let colour = Colour::HeavyTails;
            Scene::Tracer(tracer::Run { colour, n_angles: 19, ..tracer::Run::new(seed) })
        }),
    ]
}

/// The names that a profile over repeated places may have.
const PROFILE: &[&str] = &["profile", "position", "level"];
const REVERSED: &[&str] = &["reversal", "backlash", "profile", "position", "level", "direction"];

fn repeats() -> Vec<Cell> {
    use Question::{FalseAddition, Honest};
    let positions = |situation, question, make| cell(REPEATS, situation, question, make);
    vec![
        positions("linear axis, nothing, left out by cycle", FalseAddition, |seed| {
            Scene::Positions(Positions::new(seed))
        }),
        positions("linear axis, profile, left out by cycle", Honest(PROFILE), |seed| {
            Scene::Positions(Positions { profile_mm: 0.02, ..Positions::new(seed) })
        }),
        positions("linear axis, profile, left out by target", Honest(PROFILE), |seed| {
            let group = "target";
            Scene::Positions(Positions { profile_mm: 0.02, group, ..Positions::new(seed) })
        }),
        positions("linear axis, profile and reversal, by cycle", Honest(REVERSED), |seed| {
            let reversal_mm = 0.025 * sign(direction(seed));
            Scene::Positions(Positions { profile_mm: 0.02, reversal_mm, ..Positions::new(seed) })
        }),
        positions("linear axis, profile and reversal, by target", Honest(REVERSED), |seed| {
            let (group, reversal_mm) = ("target", 0.025 * sign(direction(seed)));
            let base = Positions::new(seed);
            Scene::Positions(Positions { profile_mm: 0.02, reversal_mm, group, ..base })
        }),
        positions("survey, ten targets in five rounds, nothing", FalseAddition, |seed| {
            Scene::Survey(visited(seed))
        }),
        positions("survey, ten targets in five rounds, profile", Honest(PROFILE), |seed| {
            Scene::Survey(Survey { defect: Defect::Profile(0.02), ..visited(seed) })
        }),
    ]
}

/// Ten targets, each visited once in each of five rounds.
fn visited(seed: u64) -> Survey {
    Survey { n_fit: 50, n_check: 0, rounds: 5, ..Survey::new(seed) }
}

fn outside() -> Vec<Cell> {
    let mut cells = outside_polishing();
    cells.extend(outside_machines());
    cells
}

fn outside_polishing() -> Vec<Cell> {
    use Question::Honest;
    vec![
        cell(OUTSIDE, "ft-center: presses at one load are warm", Honest(&[]), |seed| {
            let d = direction(seed);
            let fault = Fault::WarmLoad([12.0 * d[0], 12.0 * d[1]]);
            Scene::Session(Session { fault, ..varied(seed) })
        }),
        cell(OUTSIDE, "ft-center: the pad slips by 0.1 mm", Honest(&["slip"]), |seed| {
            Scene::Session(Session { fault: Fault::Slip(0.1), ..varied(seed) })
        }),
        cell(OUTSIDE, "force-impedance: one strip reads 1.5 N high", Honest(&[]), |seed| {
            let strip = usize::try_from(seed % 10).expect("below ten");
            let flaw = polish::Flaw::Strip(strip, 1.5 * sign(direction(seed)));
            Scene::Run(Run { flaw, ..Run::new(seed) })
        }),
        cell(OUTSIDE, "force-impedance: a zero settles, two times, 2 N", Honest(&[]), |seed| {
            let flaw = polish::Flaw::Settling(2.0 * sign(direction(seed)));
            Scene::Run(Run { flaw, ..Run::new(seed) })
        }),
    ]
}

/// Three loads, and a drag that differs from press to press.
fn varied(seed: u64) -> Session {
    let loads_n = vec![20.0, 35.0, 60.0];
    let base = Session { n_frame: 36, n_check: 12, declare_noise: true, ..Session::new(seed) };
    Session { loads_n, drag_varies: true, ..base }
}

/// The names of a power error of a mirror.
const POWER: &[&str] = &["vertex-radius", "conic", "tip-radius", "focus"];
const STANDS: &[&str] = &["station-drift", "stands-drift", "range-drift"];

fn outside_machines() -> Vec<Cell> {
    use Question::{FalseAddition, Honest, Named};
    vec![
        cell(OUTSIDE, "frame-fit: one session 4 K warm, not recorded", WARM, |seed| {
            let defect = Defect::WarmSession(46e-6);
            Scene::Survey(Survey { defect, n_fit: 36, n_check: 12, ..Survey::new(seed) })
        }),
        cell(OUTSIDE, "pose-icp: near-sphere, nothing", FalseAddition, |seed| {
            Scene::Mirror(near_sphere(seed))
        }),
        cell(OUTSIDE, "pose-icp: near-sphere, radius 0.24 % off", Honest(POWER), |seed| {
            let flaw = mirror::Flaw::VertexRadius(1.15 * sign(direction(seed)));
            Scene::Mirror(Mirror { flaw, ..near_sphere(seed) })
        }),
        cell(OUTSIDE, "pose-icp: a patch 6 µm low, 12 mm wide", Honest(&["patch"]), |seed| {
            let flaw = mirror::Flaw::Bump(-6e-3, 12.0);
            Scene::Mirror(Mirror { flaw, n_points: 72, ..Mirror::new(seed) })
        }),
        cell(OUTSIDE, "frame-fit: the stand sets by 30 µm in a tenth of the time", SETS, |seed| {
            let total = direction(seed).map(|v| 0.03 * v);
            let defect = Defect::Settling(total, 0.1);
            Scene::Survey(Survey { defect, ..Survey::new(seed) })
        }),
        cell(
            OUTSIDE,
            "pose-icp: the spindle warms by 10 µm in a tenth of the time",
            SETS,
            |seed| {
                let flaw = mirror::Flaw::Settling(0.01 * sign(direction(seed)), 0.1);
                Scene::Mirror(Mirror { flaw, n_points: 72, ..Mirror::new(seed) })
            },
        ),
        cell(OUTSIDE, "probe-comp: the part sets by 10 µm in a tenth of the time", SETS, |seed| {
            let flaw = probe::Flaw::Settling(direction(seed).map(|v| 0.01 * v), 0.1);
            Scene::Probe(probe::Session { flaw, n_touches: 128, ..probe::Session::new(seed) })
        }),
        cell(OUTSIDE, "probe-comp: x reverses by 6 µm", Honest(&["reversal"]), |seed| {
            let flaw = probe::Flaw::Reversal(6e-3 * sign(direction(seed)));
            Scene::Probe(probe::Session { flaw, n_touches: 128, ..probe::Session::new(seed) })
        }),
        cell(OUTSIDE, "probe-comp: a patch 6 µm low, 8 mm wide", Honest(&["patch"]), |seed| {
            let flaw = probe::Flaw::Patch(6e-3, 8.0);
            Scene::Probe(probe::Session { flaw, n_touches: 128, ..probe::Session::new(seed) })
        }),
        cell(OUTSIDE_TRACKER, "tracker-lm: every stand drifts by 30 µm", Honest(STANDS), |seed| {
            let defect = tracer_run::Defect::StandsDrift(0.03);
            Scene::Tracer(tracer::Run { defect, ..there_and_back(seed) })
        }),
        cell(
            OUTSIDE_TRACKER,
            "tracker-lm: one stand drifts by 0.1 mm",
            Named("station-drift"),
            |seed| {
                let d = direction(seed).map(|v| 0.1 * v);
                let defect = tracer_run::Defect::StationDrift(2, d);
                Scene::Tracer(tracer::Run { defect, n_angles: 19, ..tracer::Run::new(seed) })
            },
        ),
        // Last, for a cell before another changes its seeds.
        cell(OUTSIDE, "pose-icp: clamped anew, half a millimetre off", MOVED, |seed| {
            let flaw = mirror::Flaw::Clamped(40, direction(seed).map(|v| 0.5 * v));
            Scene::Mirror(Mirror { flaw, n_points: 72, ..Mirror::new(seed) })
        }),
    ]
}

const MOVED: Question = Question::Honest(&["session-shift"]);
/// A drift by whatever course, or time.
const SETS: Question = Question::Honest(&["drift"]);
const WARM: Question = Question::Honest(&["temperature", "session"]);

/// R = 480 mm, sixty-two touches, the side not touched.
fn near_sphere(seed: u64) -> Mirror {
    Mirror { radius_mm: 480.0, sides: false, n_points: 62, ..Mirror::new(seed) }
}

/// One tracer that takes one lock after the other, angles there and back.
fn there_and_back(seed: u64) -> tracer::Run {
    let base = tracer::Run::new(seed);
    tracer::Run { n_angles: 13, both_ways: true, one_tracer: true, ..base }
}
