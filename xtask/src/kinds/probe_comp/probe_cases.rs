//! Simulated sessions with a probe that are committed.

use crate::expectation::{Expectation, Number};
use crate::generators::noise::Colour;
use crate::generators::{Case, Story, generated, named_within, nothing, over_noise, words};
use crate::kinds::probe_comp::probe::{Flaw, Session, Shape, check_noise_mm, simulate};
use crate::kinds::probe_comp::probe_tables::{case_toml, touches_csv};

/// Error on check touches over the noise of those touches alone. An effect of at most three
/// amplitudes from 48 touches adds 3/48 of the variance, 3 % in the root; sixteen residuals
/// scatter by 18 % of what is added, three times which is allowed, and names take some more.
const HELD_OUT_AT_MOST: f64 = 1.25;

/// All of them.
pub(crate) fn cases() -> Vec<Case> {
    vec![
        nothing_white(),
        nothing_coloured(),
        ball_or_pretravel(),
        bad_point(),
        lobing(),
        part_lobes(),
        bending(),
        latency(),
        squareness(),
        axis_scale(),
        drift(),
        growth(),
        outside_waves(),
        outside_humidity(),
    ]
}

const BOWL: Shape = Shape::Bowl { radius_mm: 120.0 };

fn probe_case(
    folder: &str,
    session: &Session,
    title: &'static str,
    truth: &str,
    expect: Expectation,
) -> Case {
    let touches = simulate(session);
    let noise = check_noise_mm(&touches);
    let expect = over_noise(expect, noise);
    let tables =
        vec![("case.toml", case_toml(session)), ("touches.csv", touches_csv(session, &touches))];
    let part = match session.shape {
        Shape::Sphere { radius_mm } => format!("Sphere of {radius_mm} mm"),
        Shape::Bowl { radius_mm } => format!("Paraboloid bowl of R = {radius_mm} mm"),
    };
    let noise_um = session.noise_mm * 1e3;
    let tip_mm = session.tip_mm;
    let truth = format!("{truth} {part}, ball of {tip_mm} mm; noise {noise_um} µm per coordinate.");
    generated(&format!("probe-comp/{folder}"), session.seed, tables, Story { title, truth, expect })
}

/// The named effect, nothing else, and nearly nothing left on touches never fitted.
fn named(class: &[&str]) -> Expectation {
    named_within(class, HELD_OUT_AT_MOST)
}

fn nothing_white() -> Case {
    let session = Session { shape: BOWL, record_air: true, ..Session::new(81) };
    let expect = nothing(&["nothing-missing"]);
    probe_case("nothing-white", &session, "Nothing wrong", "Nothing is wrong.", expect)
}

fn nothing_coloured() -> Case {
    let session = Session {
        colour: Colour::Ar1(0.7),
        record_air: true,
        declare_noise: false,
        ..Session::new(82)
    };
    let truth = "Nothing is wrong. Successive touches are correlated by 0.7; the air temperature \
                 wanders and drives nothing.";
    let expect = nothing(&["nothing-missing"]);
    probe_case("nothing-coloured", &session, "Nothing wrong, coloured noise", truth, expect)
}

fn ball_or_pretravel() -> Case {
    let session =
        Session { flaw: Flaw::Ball(0.014), also: Flaw::Pretravel(0.006), ..Session::new(83) };
    let truth = "The ball is 14 µm larger than declared and the probe triggers 6 µm late. Along the \
                 normals of a sphere only the difference shows, 8 µm, and nothing says of which.";
    let difference = Number {
        path: "steps.0.parameters.0.value".to_owned(),
        value: 0.008,
        tolerance: 4.4e-4,
        because: "the ball less the travel; three standard uncertainties, 1 µm/√48 each".to_owned(),
    };
    let expect = Expectation {
        says: words(&["\"indistinguishable_from\":[\"pretravel\"]"]),
        loop_numbers: vec![difference],
        ..named(&["tip-radius"])
    };
    probe_case("ball-or-pretravel", &session, "Ball larger, late trigger", truth, expect)
}

fn bad_point() -> Case {
    let session = Session { flaw: Flaw::BadPoint(20, 0.012), ..Session::new(88) };
    let truth = "A chip lies under touch T21: it stops 12 µm short.";
    let expect = Expectation { says: words(&["T21"]), ..named(&["bad-point"]) };
    probe_case("bad-point", &session, "A chip under one touch", truth, expect)
}

fn lobing() -> Case {
    let session =
        Session { oblique_rad: 0.5, flaw: Flaw::Lobing([0.006, -0.004]), ..Session::new(84) };
    let truth = "The probe's three seats make three lobes: 6 and −4 µm at right angles to the \
                 stylus. The touches come from 29° beside the normal.";
    probe_case("lobing", &session, "Three lobes of the probe", truth, named(&["lobing"]))
}

fn part_lobes() -> Case {
    let session = Session { oblique_rad: 0.5, flaw: Flaw::PartLobes(0.008), ..Session::new(85) };
    let truth = "The part, not the probe, has three lobes of 8 µm. The touches come from 29° \
                 beside the normal, which tells them apart.";
    let expect = Expectation { held_out: None, ..named(&["form"]) };
    probe_case("part-lobes", &session, "Three lobes of the part", truth, expect)
}

fn bending() -> Case {
    let session = Session { flaw: Flaw::Bending(0.008), ..Session::new(86) };
    let truth = "The stylus gives way by 8 µm at right angles to it.";
    probe_case("bending", &session, "Stylus gives way", truth, named(&["bending"]))
}

fn latency() -> Case {
    let session = Session { record_feed: true, flaw: Flaw::Latency(0.002), ..Session::new(87) };
    let truth = "The machine is read 2 ms after the trigger; the feed changes from touch to touch \
                 and is recorded.";
    probe_case("latency", &session, "Read late", truth, named(&["latency"]))
}

fn squareness() -> Case {
    let flaw = Flaw::Squareness([300e-6, 0.0, 0.0]);
    let session = Session { flaw, ..Session::new(94) };
    let truth = "x and y are 300 µrad out of square.";
    probe_case("squareness", &session, "Axes out of square", truth, named(&["squareness"]))
}

fn axis_scale() -> Case {
    let flaw = Flaw::AxisScale([0.0, 350e-6, 0.0]);
    let session = Session { flaw, ..Session::new(89) };
    let truth = "The machine's y reads 350 ppm long.";
    probe_case("axis-scale", &session, "Scale of one axis", truth, named(&["axis-scale"]))
}

fn drift() -> Case {
    let flaw = Flaw::Drift([0.0, 0.0, -0.01]);
    let session = Session { flaw, ..Session::new(90) };
    let truth = "The spindle grows by 10 µm during the session (first-order warming, time constant \
                 twice the session), so not quite in proportion to time.";
    let expect = named(&["drift", "covariate:time_s"]);
    probe_case("drift", &session, "Spindle grows", truth, expect)
}

fn growth() -> Case {
    let session =
        Session { shape: BOWL, record_air: true, flaw: Flaw::Growth(0.006), ..Session::new(91) };
    let truth = "The readings of z follow the air by 6 µm/K; the temperature is recorded.";
    probe_case("temperature", &session, "Column follows the air", truth, named(&["temperature"]))
}

fn outside_waves() -> Case {
    let session =
        Session { shape: BOWL, n_touches: 96, flaw: Flaw::Waves(0.005, 23.0), ..Session::new(92) };
    let truth = "The part was planed: waves of 5 µm, 23 mm long, along x, which no effect in the \
                 catalogue describes.";
    let expect = Expectation {
        verdict: words(&["structure-remains"]),
        nothing_else: true,
        empirical_allowed: true,
        structure: vec![words(&["part_x_mm"])],
        ..Expectation::default()
    };
    probe_case("outside-waves", &session, "Waves of a planing tool", truth, expect)
}

fn outside_humidity() -> Case {
    let session = Session { flaw: Flaw::Humidity(0.0012), ..Session::new(93) };
    let truth = "The coating of the ball swells: 1.2 µm per percent of humidity. The humidity is \
                 recorded; the catalogue knows nothing of it.";
    let expect = named(&["covariate:humidity_pct"]);
    probe_case("outside-humidity", &session, "Ball swells with humidity", truth, expect)
}
