//! Situations of `probe-comp`: a sphere and a bowl touched by a ball.

use super::cells::{Cell, Question, TIMES, direction, sign};
use super::detectable::{Design, smallest};
use super::scene::Scene;
use crate::generators::Colour;
use crate::generators::probe::{Flaw, Session, Shape, simulate};

/// Effects that share the level of a session.
const CANDIDATES: usize = 17;
const BOWL: Shape = Shape::Bowl { radius_mm: 120.0 };

pub(crate) fn cells() -> Vec<Cell> {
    use Question::{ConfidentWrongName, FalseAddition, Named};
    vec![
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
        probe("sphere: ball larger", Named("ball-radius"), |seed| {
            touched(&Session::new(seed), 1, |a, d| Flaw::Ball(a * sign(d)))
        }),
        probe("bowl: ball larger", Named("ball-radius"), |seed| {
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
    ]
}

fn probe(situation: &'static str, question: Question, make: fn(u64) -> Scene) -> Cell {
    Cell { krate: "probe-comp", situation, question, make }
}

fn bowl(seed: u64) -> Session {
    Session { shape: BOWL, ..Session::new(seed) }
}

fn oblique(seed: u64) -> Session {
    Session { oblique_rad: 0.5, ..Session::new(seed) }
}

fn touched(base: &Session, n_amplitudes: usize, flaw: fn(f64, [f64; 3]) -> Flaw) -> Scene {
    let d = direction(base.seed);
    Scene::Probe(session_at(base, |a| flaw(a, d), n_amplitudes, CANDIDATES))
}

fn bad_touch(seed: u64) -> Scene {
    let d = direction(seed);
    let base = Session::new(seed);
    // Every fourth touch is only judged, beginning with the fourth.
    let index = [0, 1, 2, 4, 5, 6, 8, 9][usize::try_from(seed % 8).expect("below 8")];
    let flaw = |a: f64| Flaw::BadPoint(index, a * sign(d));
    Scene::Probe(session_at(&base, flaw, 1, CANDIDATES * base.n_touches))
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
