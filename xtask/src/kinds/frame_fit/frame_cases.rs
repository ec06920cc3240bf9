//! Simulated surveys that are committed.

use crate::expectation::{Expectation, HeldOut, Number};
use crate::generators::noise::Colour;
use crate::generators::{Case, Story, generated, named_within, nothing, over_noise, words};
use crate::kinds::frame_fit::survey::{Defect, Survey, simulate};

/// Error on check points over the noise of those points alone. A rigid fit of 18 points and an
/// effect of three amplitudes add 9/54 of the variance, 8 % in the root; with 18 residuals of
/// check points the product of that error and their noise scatters by another 8 %, three times
/// which is allowed.
const HELD_OUT_AT_MOST: f64 = 1.32;

/// All of them.
pub(crate) fn cases() -> Vec<Case> {
    vec![
        scale(),
        squareness(),
        thermal_drift(),
        sag(),
        bad_point(),
        nothing_white(),
        nothing_coloured(),
        reflection(),
        reflection_undeclared(),
        outside_lead_screw(),
        outside_cubic(),
        outside_humidity(),
    ]
}

fn survey_case(
    folder: &str,
    survey: &Survey,
    title: &'static str,
    truth: &str,
    expect: Expectation,
) -> Case {
    let surveyed = simulate(survey);
    let expect = over_noise(expect, surveyed.check_noise_mm);
    let tables = vec![("case.toml", surveyed.case_toml), ("pairs.csv", surveyed.pairs_csv)];
    let noise = match survey.colour {
        Colour::White => "white",
        Colour::Ar1(_) => "correlated from point to point",
        Colour::Pink => "1/f",
        Colour::HeavyTails => "Student's t with three degrees of freedom",
    };
    let truth = format!("{truth} Noise {} µm per coordinate, {noise}.", survey.noise_mm * 1e3);
    generated(&format!("frame-fit/{folder}"), survey.seed, tables, Story { title, truth, expect })
}

/// The named effect, nothing else, and nearly nothing left on points never fitted.
fn named(class: &[&str]) -> Expectation {
    named_within(class, HELD_OUT_AT_MOST)
}

fn scale() -> Case {
    let survey = Survey { defect: Defect::Scale(-35e-6), ..Survey::new(11) };
    let truth = "All scales of the machine are 35 ppm short, as steel 3 K below 20 °C.";
    survey_case("scale", &survey, "Machine 3 K cold", truth, named(&["scale"]))
}

fn squareness() -> Case {
    let survey = Survey { defect: Defect::Squareness([60e-6, 0.0, 0.0]), ..Survey::new(12) };
    let truth = "The y axis leans 60 µrad from the normal of x.";
    survey_case("shear", &survey, "Axes out of square", truth, named(&["shear"]))
}

fn thermal_drift() -> Case {
    let survey = Survey { defect: Defect::Drift([0.012, -0.008, 0.018]), ..Survey::new(13) };
    let truth = "The tracker's stand creeps 12, −8, 18 µm during the survey (first-order warming, \
                 time constant twice the survey), so not quite in proportion to time.";
    let expect = named(&["drift", "covariate:time_s"]);
    survey_case("thermal-drift", &survey, "Stand warms during the survey", truth, expect)
}

fn sag() -> Case {
    let survey = Survey { defect: Defect::Sag(0.030), ..Survey::new(14) };
    let truth = "The ram bends under the moving saddle, 30 µm in the middle of its supports; the \
                 deflection under a moving load goes with x²(L−x)², L = 1400 mm.";
    survey_case("sag", &survey, "Ram bends under the saddle", truth, named(&["sag"]))
}

fn bad_point() -> Case {
    let survey = Survey { defect: Defect::BadPoint(8, [0.004, 0.0, 0.025]), ..Survey::new(15) };
    let truth = "The reflector of P09 sits on a chip: 4 and 25 µm off in x and z.";
    let expect = Expectation { says: words(&["P09"]), ..named(&["bad-point"]) };
    survey_case("bad-point", &survey, "One reflector on a chip", truth, expect)
}

fn nothing_white() -> Case {
    let survey = Survey { noise_mm: 0.005, ..Survey::new(16) };
    let expect = nothing(&["nothing-missing"]);
    survey_case("nothing-white", &survey, "Nothing wrong", "Nothing is wrong.", expect)
}

fn nothing_coloured() -> Case {
    let survey = Survey {
        noise_mm: 0.005,
        colour: Colour::Ar1(0.7),
        record_air: true,
        declare_noise: false,
        ..Survey::new(17)
    };
    let truth = "Nothing is wrong. The noise of successive points is correlated by 0.7 (turbulence \
                 of the air path); the air temperature wanders and drives nothing.";
    // That successive residuals resemble each other is all there is to say.
    let expect =
        Expectation { structure: vec![words(&["order"])], ..nothing(&["structure-remains"]) };
    survey_case("nothing-coloured", &survey, "Nothing wrong, coloured noise", truth, expect)
}

fn mirrored() -> Survey {
    Survey { planar: true, mirrored: true, noise_mm: 0.01, ..Survey::new(18) }
}

fn reflection() -> Case {
    let survey = Survey { handedness: Some("improper"), ..mirrored() };
    let truth = "The second frame is a camera's with y downwards, and the case says so.";
    let expect = Expectation {
        solve_numbers: vec![Number {
            path: "residual.rms".to_owned(),
            value: 0.0135,
            tolerance: 0.005,
            because:
                "noise of 10 µm in two coordinates over 33 degrees of freedom; three standard \
                      errors are 5 µm"
                    .to_owned(),
        }],
        ..nothing(&["nothing-missing"])
    };
    survey_case("reflection", &survey, "Left-handed camera frame, declared", truth, expect)
}

fn reflection_undeclared() -> Case {
    let truth = "The second frame is a camera's with y downwards, and the case does not say so. The \
                 mirror must be told, and named.";
    let expect = Expectation {
        effects: vec![words(&["input:sign"])],
        nothing_else: true,
        says: words(&["mirrored"]),
        ..Expectation::default()
    };
    survey_case("reflection-undeclared", &mirrored(), "Left-handed camera frame", truth, expect)
}

fn outside_lead_screw() -> Case {
    let survey = Survey {
        n_fit: 36,
        n_check: 12,
        defect: Defect::LeadScrew(0.010, 40.0),
        ..Survey::new(19)
    };
    let truth = "The lead screw of x errs by 10 µm with a period of 40 mm, which no effect in the \
                 catalogue describes.";
    let expect = Expectation {
        verdict: words(&["structure-remains"]),
        nothing_else: true,
        empirical_allowed: true,
        structure: vec![words(&["from_x_mm"])],
        ..Expectation::default()
    };
    survey_case("outside-lead-screw", &survey, "Periodic lead-screw error", truth, expect)
}

fn outside_cubic() -> Case {
    let survey = Survey { n_fit: 27, n_check: 9, defect: Defect::Cubic(0.020), ..Survey::new(20) };
    let truth = "The x scale errs with the cube of x, 20 µm at the end of travel. An axis scale \
                 repairs five sixths of its variance, but not all.";
    let expect = Expectation {
        verdict: words(&["structure-remains"]),
        empirical_allowed: true,
        structure: vec![words(&["from_x_mm"])],
        ..Expectation::default()
    };
    survey_case("outside-cubic", &survey, "Cubic error of one scale", truth, expect)
}

fn outside_humidity() -> Case {
    let survey = Survey { defect: Defect::Humidity(0.0012), ..Survey::new(21) };
    let truth = "A mount of carbon-fibre composite swells 1.2 µm per percent of humidity along z. \
                 The humidity is recorded; the catalogue knows nothing of it.";
    let expect = Expectation {
        verdict: words(&["explained"]),
        effects: vec![words(&["covariate:humidity_pct"])],
        nothing_else: true,
        held_out: Some(HeldOut { noise: 0.0, at_most: HELD_OUT_AT_MOST }),
        loop_numbers: vec![Number {
            path: "before.held_out_rms".to_owned(),
            value: 0.0085,
            tolerance: 0.004,
            because: "6 % of humidity is 7 µm, with 3.5 µm of noise; 9 degrees of freedom or so"
                .to_owned(),
        }],
        ..Expectation::default()
    };
    survey_case("outside-humidity", &survey, "Mount swells with humidity", truth, expect)
}
