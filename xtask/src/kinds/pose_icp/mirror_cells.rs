//! Situations of `pose-icp`: mirrors touched on a machine.

use crate::generators::Colour;
use crate::kinds::pose_icp::mirror::{Flaw, Mirror};
use crate::power::cell::{Cell, Question, direction, sign};
use crate::power::scene::{Scene, TIMES, mirror_at};

pub(crate) fn mirrors() -> Vec<Cell> {
    use Question::{BothNamed, ConfidentWrongName, FalseAddition, Honest, Named};
    vec![
        mirror("nothing, white noise", FalseAddition, |seed| {
            Scene::Mirror(Mirror { record_air: true, ..Mirror::new(seed) })
        }),
        mirror("nothing, white noise not declared", FalseAddition, |seed| {
            Scene::Mirror(Mirror { declare_noise: false, ..Mirror::new(seed) })
        }),
        mirror("nothing, AR(1) 0.7 from touch to touch", FalseAddition, |seed| {
            let colour = Colour::Ar1(0.7);
            Scene::Mirror(Mirror { colour, record_air: true, ..Mirror::new(seed) })
        }),
        mirror("ball larger, on a near-sphere", Named("tip-radius"), |seed| {
            let base =
                Mirror { radius_mm: 60.0, conic: -0.02, diameter_mm: 80.0, ..large_mirror(seed) };
            touched(&base, 1, |a, d| Flaw::Tip(a * sign(d)))
        }),
        mirror("vertex radius", Named("vertex-radius"), |seed| {
            touched(&large_mirror(seed), 1, |a, d| Flaw::VertexRadius(a * sign(d)))
        }),
        mirror("conic constant", Named("conic"), |seed| {
            touched(&large_mirror(seed), 1, |a, d| Flaw::Conic(a * sign(d)))
        }),
        mirror("bent like a saddle", Named("astigmatism"), |seed| {
            touched(&large_mirror(seed), 2, |a, d| Flaw::Astigmatism([a * d[0], a * d[1]]))
        }),
        mirror("coma", Named("coma"), |seed| {
            touched(&large_mirror(seed), 2, |a, d| Flaw::Coma([a * d[0], a * d[1]]))
        }),
        mirror("three lobes", Named("trefoil"), |seed| {
            touched(&large_mirror(seed), 2, |a, d| Flaw::Trefoil([a * d[0], a * d[1]]))
        }),
        mirror("scale of one axis of the machine", Named("axis-scale"), |seed| {
            touched(&large_mirror(seed), 1, |a, d| Flaw::MachineScale(along_one(d).map(|v| a * v)))
        }),
        mirror("axes out of square", Named("squareness"), |seed| {
            touched(&large_mirror(seed), 1, |a, d| Flaw::Squareness([a * sign(d), 0.0, 0.0]))
        }),
        mirror("x has play, the ball comes along the normal", Named("reversal"), |seed| {
            touched(&large_mirror(seed), 1, |a, d| Flaw::Play(0, a * sign(d)))
        }),
        mirror("y has play between touches", Named("reversal"), |seed| {
            touched(&large_mirror(seed), 2, |a, d| Flaw::PlayBetween(1, a * sign(d)))
        }),
        mirror("x has play, and three lobes", BothNamed(["reversal", "trefoil"]), |seed| {
            let play = |a: f64, d: [f64; 3]| Flaw::Play(0, a * sign(d));
            both(seed, 2, play, |a, d| Flaw::Trefoil([a * d[0], a * d[1]]))
        }),
        mirror("spindle grows", Named("drift"), |seed| {
            touched(&large_mirror(seed), 1, |a, d| Flaw::Drift(a * sign(d)))
        }),
        mirror("column follows the air", Named("temperature"), |seed| {
            let base = Mirror { record_air: true, ..large_mirror(seed) };
            touched(&base, 2, |a, d| Flaw::Growth(a * sign(d)))
        }),
        mirror("one bad touch", Named("bad-point"), bad_touch),
        mirror("vertex radius, and spindle grows", BothNamed(["vertex-radius", "drift"]), |seed| {
            both(seed, 1, |a, d| Flaw::VertexRadius(a * sign(d)), |a, d| Flaw::Drift(a * sign(d)))
        }),
        mirror("saddle, and three lobes", BothNamed(["astigmatism", "trefoil"]), |seed| {
            let saddle = |a: f64, d: [f64; 3]| Flaw::Astigmatism([a * d[0], a * d[1]]);
            both(seed, 2, saddle, |a, d| Flaw::Trefoil([a * d[0], a * d[1]]))
        }),
        mirror("conic constant, and one bad touch", BothNamed(["conic", "bad-point"]), |seed| {
            let also = bad_touch_of(seed).flaw;
            let with = touched_mirror(&large_mirror(seed), 1, |a, d| Flaw::Conic(a * sign(d)));
            Scene::Mirror(Mirror { also, ..with })
        }),
        mirror("rings, 4 µm, period 16 mm", ConfidentWrongName, |seed| {
            Scene::Mirror(Mirror { flaw: Flaw::Rings(0.004, 16.0), ..large_mirror(seed) })
        }),
        mirror("a raised patch, 8 µm, 15 mm wide", Honest(&["patch"]), |seed| {
            Scene::Mirror(Mirror { flaw: Flaw::Bump(0.008, 15.0), ..large_mirror(seed) })
        }),
        mirror("humidity, 4 σ", ConfidentWrongName, |seed| {
            Scene::Mirror(Mirror { flaw: Flaw::Humidity(0.0012), ..large_mirror(seed) })
        }),
    ]
}

fn mirror(situation: &'static str, question: Question, make: fn(u64) -> Scene) -> Cell {
    Cell { krate: "pose-icp", situation, question, make }
}

/// Effects that share the level of a session with a mirror.
const MIRROR_CANDIDATES: usize = 9;

/// Fifty-four touches and eighteen check points.
fn large_mirror(seed: u64) -> Mirror {
    Mirror { n_points: 72, ..Mirror::new(seed) }
}

type Sized = fn(f64, [f64; 3]) -> Flaw;

fn touched(base: &Mirror, n_amplitudes: usize, flaw: Sized) -> Scene {
    Scene::Mirror(touched_mirror(base, n_amplitudes, flaw))
}

fn touched_mirror(base: &Mirror, n_amplitudes: usize, flaw: Sized) -> Mirror {
    let d = direction(base.seed);
    mirror_at(base, |a| flaw(a, d), n_amplitudes, MIRROR_CANDIDATES, TIMES)
}

/// Two flaws at once, each as large as it would be alone.
fn both(seed: u64, n_amplitudes: usize, first: Sized, second: Sized) -> Scene {
    let base = large_mirror(seed);
    let also = touched_mirror(&base, n_amplitudes, second).flaw;
    Scene::Mirror(Mirror { also, ..touched_mirror(&base, n_amplitudes, first) })
}

/// The axis along which `d` is longest.
fn along_one(d: [f64; 3]) -> [f64; 3] {
    let longest = d.map(f64::abs).into_iter().fold(0.0, f64::max);
    d.map(|v| if v.abs() < longest { 0.0 } else { v.signum() })
}

fn bad_touch(seed: u64) -> Scene {
    Scene::Mirror(bad_touch_of(seed))
}

fn bad_touch_of(seed: u64) -> Mirror {
    let d = direction(seed);
    let base = large_mirror(seed);
    // Every fourth touch is a check point, beginning with the fourth.
    let index = [0, 1, 2, 4, 5, 6, 8, 9][usize::try_from(seed % 8).expect("below 8")];
    let candidates = MIRROR_CANDIDATES * base.n_points;
    let flaw = |a: f64| Flaw::BadPoint(index, a * sign(d));
    mirror_at(&base, flaw, 1, candidates, TIMES)
}
