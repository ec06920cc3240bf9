//! Simulated sessions on the force sensor that are committed.

use crate::expectation::{Expectation, Number};
use crate::generators::noise::Colour;
use crate::generators::{Case, Story, generated, named, nothing, words};
use crate::kinds::ft_center::press::{Fault, Role, Session, simulate};
use crate::kinds::ft_center::press_tables::{case_toml, presses_csv, wrench_csv};

/// Verdict where nothing is missing.
const QUIET: [&str; 1] = ["nothing-missing"];

/// All of them.
pub(crate) fn cases() -> Vec<Case> {
    vec![
        locate_head(),
        upside_down(),
        nothing_coloured(),
        moment_bias_two_loads(),
        moment_bias_one_load(),
        force_gain(),
        contact_height(),
        bias_drift(),
        outside_hysteresis(),
        spindle_growth(),
    ]
}

fn session_case(
    folder: &str,
    session: &Session,
    title: &'static str,
    truth: &str,
    expect: Expectation,
) -> Case {
    let recorded = simulate(session);
    let tables = vec![
        ("case.toml", case_toml(session, &recorded)),
        ("presses.csv", presses_csv(&recorded)),
        ("wrench.csv", wrench_csv(&recorded)),
    ];
    let truth = format!(
        "{truth} The pressure centre orbits by {} mm; the pad rubs with a couple about z; the head \
         seats to {} µm; sensor noise {} N and {} N·mm, {}.",
        session.wobble_mm,
        session.seat_mm * 1e3,
        session.force_noise_n,
        session.moment_noise_nmm,
        match session.colour {
            Colour::White => "white",
            Colour::Ar1(_) => "correlated from sample to sample",
            Colour::Pink => "1/f",
            Colour::HeavyTails => "Student's t with three degrees of freedom",
        }
    );
    generated(&format!("ft-center/{folder}"), session.seed, tables, Story { title, truth, expect })
}

/// Three standard errors of one press in the machine: seat 8 µm, orbit 4 µm, and the frame's own
/// share of 3 µm, that is 9.4 µm together.
const LOCATE_TOL_MM: f64 = 0.028;

/// Where the head to be located really is, relative to where it should be.
fn offsets_of_located(session: &Session) -> Vec<Number> {
    let recorded = simulate(session);
    let located = recorded.presses.iter().enumerate().filter(|(_, p)| p.role == Role::Locate);
    located
        .flat_map(|(index, _)| {
            ["x", "y"].into_iter().zip(session.head_offset_mm).map(move |(axis, value)| Number {
                path: format!("estimates.centers.press=P{:02}.offset_{axis}_mm", index + 1),
                value,
                tolerance: LOCATE_TOL_MM,
                because: "three standard errors: seat 8 µm, orbit 4 µm, frame 3 µm".to_owned(),
            })
        })
        .collect()
}

fn locate_head() -> Case {
    let session = Session {
        n_frame: 9,
        n_check: 3,
        n_locate: 3,
        n_samples: 120,
        head_offset_mm: [0.420, -0.270],
        colour: Colour::Ar1(0.8),
        ..Session::new(31)
    };
    let truth = "Nothing is wrong with the sensor. The head of the last three presses stands 0.420, \
                 −0.270 mm from where it should.";
    let expect = Expectation { solve_numbers: offsets_of_located(&session), ..nothing(&QUIET) };
    session_case("locate-head", &session, "Locate a polishing head", truth, expect)
}

fn upside_down() -> Case {
    let session = Session {
        n_frame: 9,
        n_check: 3,
        n_locate: 2,
        upside_down: true,
        head_offset_mm: [-0.150, 0.310],
        ..Session::new(32)
    };
    let truth = "The sensor hangs upside down, so the planar map is a reflection. The head of the \
                 last two presses stands −0.150, 0.310 mm from where it should.";
    let expect = Expectation {
        says: words(&["reflection"]),
        solve_numbers: offsets_of_located(&session),
        ..nothing(&QUIET)
    };
    session_case("upside-down", &session, "Sensor upside down", truth, expect)
}

fn nothing_coloured() -> Case {
    let session = Session { colour: Colour::Pink, drag: 0.15, wobble_mm: 1.2, ..Session::new(33) };
    let truth = "Nothing is wrong.";
    session_case(
        "nothing-coloured",
        &session,
        "Nothing wrong, 1/f noise and wobble",
        truth,
        nothing(&QUIET),
    )
}

fn moment_bias_two_loads() -> Case {
    let fault = Fault::Bias([0.0, 0.0, 0.0, 9.0, -6.0, 0.0]);
    let session = Session { fault, ..Session::new(34) };
    let truth = "Moments read 9 and −6 N·mm too high; the presses alternate between 20 N and 60 N.";
    session_case(
        "moment-bias-two-loads",
        &session,
        "Moment bias, two loads",
        truth,
        named(&["sensor-bias"]),
    )
}

fn moment_bias_one_load() -> Case {
    let fault = Fault::Bias([0.0, 0.0, 0.0, 9.0, -6.0, 0.0]);
    let session = Session { fault, loads_n: vec![40.0], ..Session::new(35) };
    let truth = "Moments read 9 and −6 N·mm too high, but every press has the same 40 N: the bias \
                 only moves the frame.";
    let expect = Expectation {
        not_observable: words(&["sensor-bias"]),
        says: words(&["press at a second load"]),
        ..nothing(&QUIET)
    };
    session_case("moment-bias-one-load", &session, "Moment bias, one load", truth, expect)
}

fn force_gain() -> Case {
    let session = Session { fault: Fault::ForceGain(0.02), ..Session::new(36) };
    let truth = "The normal force reads 2 % high, so every centre lies 2 % too near the sensor's axis; \
                 with little sideways force that is a gain like any other.";
    let expect = named(&["force-gain", "moment-gain", "frame-scale"]);
    session_case("force-gain", &session, "Normal force 2 % high", truth, expect)
}

fn contact_height() -> Case {
    let session = Session { fault: Fault::ContactHeight(1.5), drag: 0.2, ..Session::new(37) };
    let truth = "The platform is 1.5 mm thicker than declared, and the head is dragged sideways with a \
                 fifth of its load, each press in another direction.";
    session_case(
        "contact-height",
        &session,
        "Platform 1.5 mm thicker",
        truth,
        named(&["contact-height"]),
    )
}

fn bias_drift() -> Case {
    let fault = Fault::BiasDrift([0.0, 0.0, 0.0, 18.0, 12.0, 0.0]);
    let session = Session { fault, loads_n: vec![20.0, 40.0, 60.0], ..Session::new(38) };
    let truth = "The moment channels drift by 18 and 12 N·mm during the session of 36 minutes.";
    session_case(
        "bias-drift",
        &session,
        "Sensor drifts during the session",
        truth,
        named(&["bias-drift"]),
    )
}

fn outside_hysteresis() -> Case {
    let session = Session {
        fault: Fault::Hysteresis(12.0),
        loads_n: vec![20.0, 35.0, 60.0],
        ..Session::new(39)
    };
    let truth = "The moment bridges have 12 N·mm of mechanical play: what they read depends on where \
                 they came from. No effect in the catalogue describes that.";
    let expect = Expectation {
        verdict: words(&["structure-remains"]),
        nothing_else: true,
        // Play makes the record forget, now and then, that the head spins.
        structure: vec![words(&["spin"])],
        ..Expectation::default()
    };
    session_case("outside-hysteresis", &session, "Play in the moment bridges", truth, expect)
}

fn spindle_growth() -> Case {
    let session = Session {
        fault: Fault::SpindleGrowth([0.10, -0.06]),
        loads_n: vec![20.0, 60.0],
        ..Session::new(40)
    };
    let truth = "The warming spindle housing moves the head by 0.10, −0.06 mm, most of it in the first \
                 third of the session. That moves the head, not the sensor's bias.";
    session_case("spindle-growth", &session, "Spindle housing warms", truth, named(&["drift"]))
}
