//! Situations of `probe-comp`: a sphere and a bowl touched by a ball.

use crate::generators::Colour;
use crate::kinds::probe_comp::probe::{Flaw, Session, Shape, simulate};
use crate::power::cell::{Cell, Question, direction, sign};
use crate::power::detectable::{Design, smallest};
use crate::power::scene::{Scene, TIMES};

/// Effects that share the level of a session.
const CANDIDATES: usize = 17;
const BOWL: Shape = Shape::Bowl { radius_mm: 120.0 };

pub(crate) fn cells() -> Vec<Cell> {
    use Question::{ConfidentWrongName, FalseAddition, Named};
    let mut cells = vec![
        probe("sphere: nothing, white noise", FalseAddition, |seed| {
            Scene::Probe(Session { record_air: true, record_feed: true, ..Session::new(seed) })
        }),
        probe("bowl: nothing, white noise not declared", FalseAddition, |seed| {
            Scene::Probe(Session { shape: BOWL, declare_noise: false, ..Session::new(seed) })
        }),
        probe("sphere: nothing, AR(1) 0.7 from touch to touch", FalseAddition, |seed| {
            let colour = Colour::Ar1(0.7);
            Scene::Probe(Session { colour, record_air: true, ..Session::new(seed) })
        }),
        probe("sphere: ball larger", Named("tip-radius"), |seed| {
            touched(&Session::new(seed), 1, |a, d| Flaw::Ball(a * sign(d)))
        }),
        probe("bowl: ball larger", Named("tip-radius"), |seed| {
            touched(&bowl(seed), 1, |a, d| Flaw::Ball(a * sign(d)))
        }),
        probe("sphere: late trigger", Named("pretravel"), |seed| {
            touched(&Session::new(seed), 1, |a, d| Flaw::Pretravel(a * sign(d)))
        }),
        probe("sphere, oblique: three lobes of the probe", Named("lobing"), |seed| {
            touched(&oblique(seed), 2, |a, d| Flaw::Lobing([a * d[0], a * d[1]]))
        }),
        probe("sphere, oblique: three lobes of the part", Named("form"), |seed| {
            touched(&oblique(seed), 7, |a, d| Flaw::PartLobes(a * sign(d)))
        }),
        probe("sphere: stylus gives way", Named("bending"), |seed| {
            touched(&Session::new(seed), 1, |a, d| Flaw::Bending(a * sign(d)))
        }),
        probe("sphere: read late, feed recorded", Named("latency"), |seed| {
            let base = Session { record_feed: true, ..Session::new(seed) };
            touched(&base, 1, |a, d| Flaw::Latency(a * sign(d)))
        }),
        probe("sphere: axes out of square", Named("squareness"), |seed| {
            touched(&Session::new(seed), 3, |a, d| Flaw::Squareness(d.map(|v| a * v)))
        }),
        probe("sphere: scale of one axis", Named("axis-scale"), |seed| {
            touched(&Session::new(seed), 1, |a, d| Flaw::AxisScale([0.0, a * sign(d), 0.0]))
        }),
        probe("sphere: machine drifts", Named("drift"), |seed| {
            touched(&Session::new(seed), 3, |a, d| Flaw::Drift(d.map(|v| a * v)))
        }),
        probe("bowl: column follows the air", Named("temperature"), |seed| {
            let base = Session { record_air: true, ..bowl(seed) };
            touched(&base, 2, |a, d| Flaw::Growth(a * sign(d)))
        }),
        probe("sphere: one bad touch", Named("bad-point"), bad_touch),
        probe("bowl: waves, 5 µm, 23 mm long", ConfidentWrongName, |seed| {
            Scene::Probe(Session { flaw: Flaw::Waves(0.005, 23.0), n_touches: 96, ..bowl(seed) })
        }),
        probe("sphere: humidity, 5 σ", ConfidentWrongName, |seed| {
            Scene::Probe(Session { flaw: Flaw::Humidity(0.0012), ..Session::new(seed) })
        }),
    ];
    cells.extend(two_at_once());
    cells
}

fn two_at_once() -> Vec<Cell> {
    use Question::BothNamed;
    vec![
        probe("sphere: ball larger, machine drifts", BothNamed(["tip-radius", "drift"]), |seed| {
            let ball = touched_session(&long(seed), 1, |a, d| Flaw::Ball(a * sign(d)));
            both(&ball, 3, |a, d| Flaw::Drift(d.map(|v| a * v)))
        }),
        probe(
            "sphere: stylus gives way, one bad touch",
            BothNamed(["bending", "bad-point"]),
            |seed| {
                let also = session_with_bad_touch(&long(seed)).flaw;
                let bent = touched_session(&long(seed), 1, |a, d| Flaw::Bending(a * sign(d)));
                Scene::Probe(Session { also, ..bent })
            },
        ),
        probe(
            "sphere, oblique: lobes of the part and of the probe",
            BothNamed(["form", "lobing"]),
            |seed| {
                let base = Session { oblique_rad: 0.5, ..long(seed) };
                let part = touched_session(&base, 7, |a, d| Flaw::PartLobes(a * sign(d)));
                both(&part, 2, |a, d| Flaw::Lobing([a * d[0], a * d[1]]))
            },
        ),
    ]
}

fn probe(situation: &'static str, question: Question, make: fn(u64) -> Scene) -> Cell {
    Cell { krate: "probe-comp", situation, question, make }
}

fn bowl(seed: u64) -> Session {
    Session { shape: BOWL, ..Session::new(seed) }
}

/// Ninety-six touches that are fitted: nine amplitudes of two effects add 9/96 of the variance to
/// touches never seen, 5 % in the root.
fn long(seed: u64) -> Session {
    Session { n_touches: 128, ..Session::new(seed) }
}

fn oblique(seed: u64) -> Session {
    Session { oblique_rad: 0.5, ..Session::new(seed) }
}

fn touched(base: &Session, n_amplitudes: usize, flaw: fn(f64, [f64; 3]) -> Flaw) -> Scene {
    Scene::Probe(touched_session(base, n_amplitudes, flaw))
}

fn touched_session(
    base: &Session,
    n_amplitudes: usize,
    flaw: fn(f64, [f64; 3]) -> Flaw,
) -> Session {
    let d = direction(base.seed);
    session_at(base, |a| flaw(a, d), n_amplitudes, CANDIDATES)
}

/// Another flaw beside that of a session, as large as it would be alone.
fn both(session: &Session, n_amplitudes: usize, other: fn(f64, [f64; 3]) -> Flaw) -> Scene {
    let alone = Session { flaw: Flaw::None, ..session.clone() };
    let also = touched_session(&alone, n_amplitudes, other).flaw;
    Scene::Probe(Session { also, ..session.clone() })
}

fn bad_touch(seed: u64) -> Scene {
    Scene::Probe(session_with_bad_touch(&Session::new(seed)))
}

fn session_with_bad_touch(base: &Session) -> Session {
    let d = direction(base.seed);
    // Every fourth touch is only judged, beginning with the fourth.
    let index = [0, 1, 2, 4, 5, 6, 8, 9][usize::try_from(base.seed % 8).expect("below 8")];
    let flaw = |a: f64| Flaw::BadPoint(index, a * sign(d));
    session_at(base, flaw, 1, CANDIDATES * base.n_touches)
}

/// Scales the flaw, given at a small size, to [`TIMES`] its minimal detectable size. The declared
/// probe has no free parameters.
fn session_at(
    session: &Session,
    flaw: impl Fn(f64) -> Flaw,
    n_amplitudes: usize,
    n_candidates: usize,
) -> Session {
    const SMALL: f64 = 1e-4;
    let touches = simulate(&Session { flaw: flaw(SMALL), ..session.clone() });
    let fitted = touches.iter().filter(|t| !t.is_check);
    let signal = fitted.map(|t| t.signal_mm / session.noise_mm).collect();
    let design = Design { signal, base: Vec::new(), n_amplitudes, n_candidates };
    Session { flaw: flaw(TIMES * smallest(&design) * SMALL), ..session.clone() }
}
