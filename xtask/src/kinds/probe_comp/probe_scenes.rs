//! Small sessions with a probe in which every effect is accepted at least once.

use crate::generators::vector::{add, cross, scale};
use crate::handback::as_f64;
use crate::handback::folder::with_column;
use crate::kinds::probe_comp::probe::{Flaw, Session, Shape, Touch, simulate};
use crate::kinds::probe_comp::probe_tables::{case_toml, touches_csv};

/// Ids with subjects that have a formula of their own.
pub(crate) const EFFECTS: &[&str] = &[
    "tip-radius",
    "pretravel",
    "bending",
    "latency",
    "lobing [with the sideways part of the approach]",
    "axis-scale [x]",
    "axis-scale [y]",
    "axis-scale [z]",
    "squareness",
    "drift [machine]",
    "drift [machine, settling]",
    "drift [machine, settling to zero]",
    "temperature",
    "form [ellipsoid]",
    "form [lobes]",
    "focus",
    "astigmatism",
    "coma",
    "trefoil",
    "patch",
    "datum-shift",
    "datum-turn",
    "drift [trigger]",
    "session-shift [machine, from",
    "session-shift [trigger, from",
    "reversal [x, by direction]",
    "bad-point",
];

type Files = Vec<(&'static str, String)>;

/// Cases by name.
pub(crate) fn scenes() -> Vec<(&'static str, Files)> {
    let base = Session::new(92);
    let bowl = Session { shape: Shape::Bowl { radius_mm: 120.0 }, ..base.clone() };
    // From other sides than its normals a bent part is told from a stylus that gives way.
    let tilted_bowl = Session { oblique_rad: 0.5, ..bowl.clone() };
    let oblique = Session { oblique_rad: 0.5, ..base.clone() };
    let with = |flaw: Flaw| Session { flaw, ..base.clone() };
    vec![
        ("tip-radius", files(&Session { flaw: Flaw::Ball(0.006), ..oblique.clone() })),
        ("pretravel", from_two_sides(&Session { flaw: Flaw::Pretravel(0.02), ..oblique.clone() })),
        ("bending", files(&with(Flaw::Bending(0.012)))),
        ("latency", files(&Session { record_feed: true, ..with(Flaw::Latency(3e-3)) })),
        ("lobing", files(&Session { flaw: Flaw::Lobing([0.010, 0.004]), ..oblique.clone() })),
        ("scale-x", files(&with(Flaw::AxisScale([6e-4, 0.0, 0.0])))),
        ("scale-y", files(&with(Flaw::AxisScale([0.0, 6e-4, 0.0])))),
        ("scale-z", files(&with(Flaw::AxisScale([0.0, 0.0, 6e-4])))),
        ("squareness", files(&with(Flaw::Squareness([4e-4, -3e-4, 2e-4])))),
        ("drift", files(&with(Flaw::Drift([0.008, -0.006, 0.01])))),
        ("settling", files(&with(Flaw::Settling([0.008, -0.006, 0.02], 0.08)))),
        (
            "settling-to-zero",
            moved(&oblique, |_, share| scale((-share / 0.15).exp(), [0.02, -0.015, 0.03])),
        ),
        ("temperature", files(&Session { record_air: true, flaw: Flaw::Growth(0.01), ..bowl })),
        ("form", files(&Session { flaw: Flaw::PartLobes(0.012), ..oblique })),
        ("ellipsoid", bent(&oblique, |[x, y, _]| 0.02 * (x * x - y * y + x * y))),
        ("focus", bent(&tilted_bowl, |[x, y, _]| 0.02 * (x * x + y * y))),
        ("astigmatism", bent(&bowl, |[x, y, _]| 0.02 * (x * x - y * y))),
        ("coma", bent(&bowl, |[x, y, _]| 0.02 * (3.0 * (x * x + y * y) - 2.0) * x)),
        ("trefoil", bent(&bowl, |[x, y, _]| 0.02 * x * (x * x - 3.0 * y * y))),
        ("patch", files(&Session { n_touches: 128, ..with(Flaw::Patch(0.02, 8.0)) })),
        ("datum-shift", moved(&bowl, |_, _| [0.02, -0.015, 0.01])),
        ("datum-turn", moved(&bowl, |touch, _| cross([4e-4, -3e-4, 0.0], touch.contact_mm))),
        ("drift-of-trigger", moved(&oblique, |touch, share| scale(0.03 * share, touch.approach))),
        ("session", moved(&oblique, |_, share| scale(later(share), [0.02, -0.03, 0.025]))),
        (
            "session-in-between",
            moved(&oblique, |_, share| {
                scale(later(share) - later(share - 0.3), [0.02, -0.03, 0.025])
            }),
        ),
        (
            "session-of-trigger",
            moved(&oblique, |touch, share| scale(0.03 * later(share), touch.approach)),
        ),
        ("to-and-fro", to_and_fro(&oblique, [0.015, 0.0, 0.0])),
        ("bad-point", files(&with(Flaw::BadPoint(5, 0.02)))),
    ]
}

/// A part that is higher by this at a place, in units of fifty millimetres or the sphere's radius.
fn bent(session: &Session, height: fn([f64; 3]) -> f64) -> Files {
    let unit_mm = match session.shape {
        Shape::Sphere { radius_mm } => radius_mm,
        Shape::Bowl { .. } => 50.0,
    };
    let touches = simulate(session).into_iter().map(|touch| {
        let raised = scale(height(scale(1.0 / unit_mm, touch.contact_mm)), touch.normal);
        Touch { read_mm: add(touch.read_mm, raised), ..touch }
    });
    of_touches(session, &touches.collect::<Vec<_>>())
}

/// Readings that are off by this at a touch and at a share of the session.
fn moved(session: &Session, by: fn(&Touch, f64) -> [f64; 3]) -> Files {
    let mut touches = simulate(session);
    let last = as_f64(touches.len() - 1);
    for (index, touch) in touches.iter_mut().enumerate() {
        touch.read_mm = add(touch.read_mm, by(touch, as_f64(index) / last));
    }
    of_touches(session, &touches)
}

/// Readings that are off by this one way and by as much the other, in turns of four, and a column that says which.
fn to_and_fro(session: &Session, half_mm: [f64; 3]) -> Files {
    let way = |index: usize| if index % 8 < 4 { 1.0 } else { -1.0 };
    let mut touches = simulate(session);
    for (index, touch) in touches.iter_mut().enumerate() {
        touch.read_mm = add(touch.read_mm, scale(way(index), half_mm));
    }
    let directions = (0..touches.len()).map(|index| way(index).to_string());
    let mut files = of_touches(session, &touches);
    for (_, text) in files.iter_mut().filter(|(name, _)| *name == "touches.csv") {
        *text = with_column(text, "direction", directions.clone());
    }
    files
}

/// Nought in the first two fifths of a session, one from then on.
fn later(share: f64) -> f64 {
    f64::from(u8::from(share > 0.4))
}

/// Every other touch along its normal: from one side alone a late trigger is a larger ball.
fn from_two_sides(session: &Session) -> Files {
    let straight = simulate(&Session { oblique_rad: 0.0, ..session.clone() });
    let mut touches = simulate(session);
    for (touch, straight) in touches.iter_mut().zip(straight).step_by(2) {
        *touch = straight;
    }
    of_touches(session, &touches)
}

fn files(session: &Session) -> Files {
    of_touches(session, &simulate(session))
}

fn of_touches(session: &Session, touches: &[Touch]) -> Files {
    vec![("case.toml", case_toml(session)), ("touches.csv", touches_csv(session, touches))]
}
