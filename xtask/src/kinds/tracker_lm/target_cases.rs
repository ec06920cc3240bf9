//! Simulated surveys of points on a rotary axis that are committed.

use crate::expectation::{Expectation, HeldOut};
use crate::generators::{Case, Story, generated, words};
use crate::kinds::tracker_lm::targets::{Fault, Survey, simulate, tables};

/// All of them.
pub(crate) fn cases() -> Vec<Case> {
    vec![nothing(), backlash(), flexure(), stand()]
}

fn case(
    folder: &str,
    survey: &Survey,
    title: &'static str,
    truth: &str,
    expect: Expectation,
) -> Case {
    let measured = simulate(survey);
    let truth = format!(
        "{truth} {} trackers; {} reflectors on two bodies, 0.3 mm off their nominal places; {} \
         angles; noise {} µm along the beam and {} µrad across it.",
        survey.n_stations,
        survey.n_mounts,
        survey.n_angles,
        survey.range_mm * 1e3,
        survey.angle_rad * 1e6,
    );
    let held_out = Some(HeldOut { noise: measured.noise_mm, at_most: 1.25 });
    let story = Story { title, truth, expect: Expectation { held_out, ..expect } };
    generated(&format!("tracker-lm/{folder}"), survey.seed, tables(survey, &measured), story)
}

fn nothing() -> Case {
    let expect = Expectation {
        verdict: words(&["nothing-missing"]),
        nothing_else: true,
        not_observable: words(&["range-scale", "backlash"]),
        ..Expectation::default()
    };
    case("targets-nothing", &Survey::new(81), "Points, nothing wrong", "Nothing is wrong.", expect)
}

fn named(effect: &str) -> Expectation {
    Expectation {
        verdict: words(&["explained"]),
        effects: vec![words(&[effect])],
        nothing_else: true,
        ..Expectation::default()
    }
}

fn backlash() -> Case {
    let fault = Fault::Backlash(25e-6, [0.0, 0.010, 0.0]);
    let survey = Survey { both_ways: true, fault, ..Survey::new(82) };
    let truth = "The drive has 25 µrad of play, and the bearing gives by 10 µm along the axis.";
    case("targets-backlash", &survey, "Points, with backlash", truth, named("backlash"))
}

fn flexure() -> Case {
    let survey = Survey { fault: Fault::Flexure(0.040), n_mounts: 8, ..Survey::new(83) };
    let truth = "The second body gives by up to 40 µm along x of the turning frame as it swings.";
    case("targets-flexure", &survey, "Points, a body that sags", truth, named("body-sag"))
}

fn stand() -> Case {
    let fault = Fault::Stand(1, [0.030, -0.020, 0.045], [15e-6, 20e-6, -10e-6]);
    let survey = Survey { fault, n_angles: 25, ..Survey::new(84) };
    let truth = "The stand of S2 moves steadily, by 58 µm and 27 µrad in all.";
    case("targets-stand", &survey, "Points, a stand that gives way", truth, named("station-drift"))
}
