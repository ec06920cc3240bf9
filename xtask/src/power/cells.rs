//! The situations whose statistics are measured.

use crate::generators::Colour;
use crate::kinds::force_impedance::run_cells::runs;
use crate::kinds::frame_fit::survey::{Defect, Survey};
use crate::kinds::ft_center::press::{Fault, Session};
use crate::kinds::pose_icp::mirror_cells::mirrors;
use crate::power::cell::{Cell, Question, direction, sign};
use crate::power::scene::{Scene, TIMES, session_at, survey_at};

/// All cells.
pub(crate) fn cells() -> Vec<Cell> {
    let mut cells = surveys();
    cells.extend(sessions());
    cells.extend(mirrors());
    cells.extend(runs());
    cells.extend(crate::kinds::tracker_lm::tracer_cells::cells());
    cells.extend(crate::kinds::tracker_lm::target_cells::cells());
    cells.extend(crate::kinds::probe_comp::probe_cells::cells());
    cells.extend(crate::power::harder_cells::cells());
    cells
}

fn survey(situation: &'static str, question: Question, make: fn(u64) -> Scene) -> Cell {
    Cell { krate: "frame-fit", situation, question, make }
}

fn session(situation: &'static str, question: Question, make: fn(u64) -> Scene) -> Cell {
    Cell { krate: "ft-center", situation, question, make }
}

fn surveys() -> Vec<Cell> {
    use Question::{BothNamed, ConfidentWrongName, FalseAddition, Named};
    vec![
        survey("nothing, white noise", FalseAddition, |seed| {
            Scene::Survey(Survey { record_air: true, ..Survey::new(seed) })
        }),
        survey("nothing, white noise not declared", FalseAddition, |seed| {
            Scene::Survey(Survey { declare_noise: false, ..Survey::new(seed) })
        }),
        survey("nothing, AR(1) 0.7 from point to point", FalseAddition, |seed| {
            let colour = Colour::Ar1(0.7);
            Scene::Survey(Survey { colour, record_air: true, ..Survey::new(seed) })
        }),
        survey("nothing, 1/f from point to point", FalseAddition, |seed| {
            Scene::Survey(Survey { colour: Colour::Pink, ..Survey::new(seed) })
        }),
        survey("frames shifted", Named("shift"), |seed| {
            common(seed, 3, |a, d| Defect::Shift(d.map(|v| a * v)))
        }),
        survey("frames rotated", Named("rotation"), |seed| {
            common(seed, 3, |a, d| Defect::Rotation(d.map(|v| a * v)))
        }),
        survey("scale", Named("scale"), |seed| rigid(seed, 1, |a, d| Defect::Scale(a * sign(d)))),
        survey("scale of each axis", Named("anisotropic-scale"), |seed| {
            rigid(seed, 3, |a, d| Defect::AxisScale(d.map(|v| a * v)))
        }),
        survey("axes out of square", Named("shear"), |seed| {
            rigid(seed, 3, |a, d| Defect::Squareness(d.map(|v| a * v)))
        }),
        survey("one bad point", Named("bad-point"), bad_point),
        survey("stand drifts", Named("drift"), |seed| {
            rigid(seed, 3, |a, d| Defect::Drift(d.map(|v| a * v)))
        }),
        survey("ram sags", Named("sag"), |seed| rigid(seed, 3, |a, d| Defect::Sag(a * sign(d)))),
        survey("thermal expansion", Named("temperature"), |seed| {
            let base = Survey { record_air: true, ..large(seed) };
            let d = direction(seed);
            Scene::Survey(survey_at(&base, |a| Defect::Expansion(a * sign(d)), 1, 7, TIMES))
        }),
        survey("scale, and ram sags", BothNamed(["scale", "sag"]), |seed| {
            with_scale(seed, 3, |a, d| Defect::Sag(a * sign(d)))
        }),
        survey("scale, and stand drifts", BothNamed(["scale", "drift"]), |seed| {
            with_scale(seed, 3, |a, d| Defect::Drift(d.map(|v| a * v)))
        }),
        survey("scale, and one bad point", BothNamed(["scale", "bad-point"]), |seed| {
            let also = survey_with_bad_point(seed).defect;
            Scene::Survey(Survey {
                also,
                ..rigid_survey(seed, 1, |a, d| Defect::Scale(a * sign(d)))
            })
        }),
        survey("lead screw, period 40 mm, 5 σ", ConfidentWrongName, |seed| {
            outside(seed, Defect::LeadScrew(0.010, 40.0))
        }),
        survey("cubic error of x, 10 σ", ConfidentWrongName, |seed| {
            outside(seed, Defect::Cubic(0.020))
        }),
        survey("humidity, 4 σ", ConfidentWrongName, |seed| {
            outside(seed, Defect::Humidity(0.0013))
        }),
    ]
}

fn sessions() -> Vec<Cell> {
    use Question::{BothNamed, ConfidentWrongName, FalseAddition, Named};
    vec![
        session("nothing, white noise", FalseAddition, |seed| Scene::Session(Session::new(seed))),
        session("nothing, AR(1) 0.95 from sample to sample", FalseAddition, |seed| {
            Scene::Session(Session { colour: Colour::Ar1(0.95), ..Session::new(seed) })
        }),
        session("nothing, 1/f noise, one load, noise declared", FalseAddition, |seed| {
            Scene::Session(Session {
                colour: Colour::Pink,
                loads_n: vec![40.0],
                declare_noise: true,
                ..Session::new(seed)
            })
        }),
        session("moment bias", Named("sensor-bias"), |seed| {
            pressed(seed, 2, |a, d| Fault::Bias(moments(a, d)))
        }),
        session("normal force bias", Named("sensor-bias"), |seed| {
            pressed(seed, 1, |a, d| Fault::Bias([0.0, 0.0, a * sign(d), 0.0, 0.0, 0.0]))
        }),
        session("moment channels drift", Named("bias-drift"), |seed| {
            pressed(seed, 2, |a, d| Fault::BiasDrift(moments(a, d)))
        }),
        session("moment channels drift and come to rest", Named("bias-drift"), |seed| {
            pressed(seed, 2, |a, d| Fault::BiasSettles(moments(a, d)))
        }),
        session("moment gain", Named("moment-gain"), |seed| {
            pressed(seed, 1, |a, d| Fault::MomentGain(a * sign(d)))
        }),
        session("force gain", Named("force-gain"), |seed| {
            pressed(seed, 1, |a, d| Fault::ForceGain(a * sign(d)))
        }),
        session("normal force reads a share of Mx", Named("crosstalk"), |seed| {
            pressed(seed, 2, |a, d| Fault::Crosstalk(2, 3, a * sign(d)))
        }),
        session("My reads a share of Fy", Named("crosstalk"), |seed| {
            pressed(seed, 4, |a, d| Fault::Crosstalk(4, 1, a * sign(d)))
        }),
        session("platform thicker than declared", Named("contact-height"), |seed| {
            pressed(seed, 1, |a, d| Fault::ContactHeight(a * sign(d)))
        }),
        session("platform leans", Named("platform-tilt"), |seed| {
            pressed(seed, 2, |a, d| Fault::PlatformTilt([a * d[0], a * d[1]]))
        }),
        session("head gives way under load", Named("load-shift"), |seed| {
            pressed(seed, 2, |a, d| Fault::LoadShift([a * d[0], a * d[1]]))
        }),
        session("machine scale", Named("frame-scale"), |seed| {
            pressed(seed, 1, |a, d| Fault::FrameScale(a * sign(d)))
        }),
        session(
            "moment gain, and moment channels drift",
            BothNamed(["moment-gain", "bias-drift"]),
            |seed| with_moment_gain(seed, 2, |a, d| Fault::BiasDrift(moments(a, d))),
        ),
        session(
            "moment gain, and head gives way",
            BothNamed(["moment-gain", "load-shift"]),
            |seed| with_moment_gain(seed, 2, |a, d| Fault::LoadShift([a * d[0], a * d[1]])),
        ),
        session("play in the moment bridges, 12 N·mm", ConfidentWrongName, |seed| {
            let loads_n = vec![20.0, 35.0, 60.0];
            Scene::Session(Session {
                fault: Fault::Hysteresis(12.0),
                loads_n,
                ..Session::new(seed)
            })
        }),
        session("spindle housing warms, 0.12 mm", Named("drift"), |seed| {
            let d = direction(seed);
            let end = f64::hypot(d[0], d[1]);
            let fault = Fault::SpindleGrowth([0.12 * d[0] / end, 0.12 * d[1] / end]);
            Scene::Session(Session { fault, ..Session::new(seed) })
        }),
        session("normal force not linear, 2 % at 60 N", ConfidentWrongName, |seed| {
            let loads_n = vec![20.0, 35.0, 60.0];
            let fault = Fault::ForceCurvature(0.02 / 60.0);
            Scene::Session(Session { loads_n, fault, ..Session::new(seed) })
        }),
    ]
}

/// Effects that share the level of a rigid survey without and with transform, and of a session.
const RIGID_CANDIDATES: usize = 6;
const COMMON_CANDIDATES: usize = 8;
const PRESS_CANDIDATES: usize = 17;

/// Thirty-six points and twelve check points: a rigid fit with an effect of three amplitudes adds
/// 9/108 of the variance to points it never saw, 4 % in the root.
fn large(seed: u64) -> Survey {
    Survey { n_fit: 36, n_check: 12, ..Survey::new(seed) }
}

type Sized<T> = fn(f64, [f64; 3]) -> T;

fn rigid(seed: u64, n_amplitudes: usize, defect: Sized<Defect>) -> Scene {
    Scene::Survey(rigid_survey(seed, n_amplitudes, defect))
}

fn rigid_survey(seed: u64, n_amplitudes: usize, defect: Sized<Defect>) -> Survey {
    let d = direction(seed);
    survey_at(&large(seed), |a| defect(a, d), n_amplitudes, RIGID_CANDIDATES, TIMES)
}

/// A scale beside another defect, each as large as it would be alone.
fn with_scale(seed: u64, n_amplitudes: usize, other: Sized<Defect>) -> Scene {
    let also = rigid_survey(seed, n_amplitudes, other).defect;
    Scene::Survey(Survey { also, ..rigid_survey(seed, 1, |a, d| Defect::Scale(a * sign(d))) })
}

/// Two frames claimed to be one.
fn common(seed: u64, n_amplitudes: usize, defect: Sized<Defect>) -> Scene {
    let d = direction(seed);
    let base = Survey { common_frame: true, transform: "none", ..large(seed) };
    Scene::Survey(survey_at(&base, |a| defect(a, d), n_amplitudes, COMMON_CANDIDATES, TIMES))
}

fn bad_point(seed: u64) -> Scene {
    Scene::Survey(survey_with_bad_point(seed))
}

fn survey_with_bad_point(seed: u64) -> Survey {
    let d = direction(seed);
    let base = large(seed);
    // Every fourth point is a check point, beginning with the fourth.
    let index = [0, 1, 2, 4, 5, 6, 8, 9][usize::try_from(seed % 8).expect("below 8")];
    let candidates = RIGID_CANDIDATES * base.n_fit;
    let defect = |a: f64| Defect::BadPoint(index, d.map(|v| a * v));
    survey_at(&base, defect, 3, candidates, TIMES)
}

fn outside(seed: u64, defect: Defect) -> Scene {
    Scene::Survey(Survey { defect, ..large(seed) })
}

/// Twenty-seven presses and nine check presses: a frame with an effect of four amplitudes adds 7/54
/// of the variance to presses it never saw, 6 % in the root.
fn pressed(seed: u64, n_amplitudes: usize, fault: Sized<Fault>) -> Scene {
    Scene::Session(pressed_session(seed, n_amplitudes, fault))
}

fn pressed_session(seed: u64, n_amplitudes: usize, fault: Sized<Fault>) -> Session {
    let d = direction(seed);
    let base = Session {
        n_frame: 27,
        n_check: 9,
        loads_n: vec![20.0, 35.0, 60.0],
        drag: 0.15,
        ..Session::new(seed)
    };
    session_at(&base, |a| fault(a, d), n_amplitudes, PRESS_CANDIDATES, TIMES)
}

/// A gain of the moments beside another fault, each as large as it would be alone.
fn with_moment_gain(seed: u64, n_amplitudes: usize, other: Sized<Fault>) -> Scene {
    let also = pressed_session(seed, n_amplitudes, other).fault;
    let with = pressed_session(seed, 1, |a, d| Fault::MomentGain(a * sign(d)));
    Scene::Session(Session { also, ..with })
}

/// Bias of Mx and My, N·mm.
fn moments(size: f64, d: [f64; 3]) -> [f64; 6] {
    [0.0, 0.0, 0.0, size * d[0], size * d[1], 0.0]
}
