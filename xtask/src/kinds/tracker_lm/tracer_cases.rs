//! Simulated runs of a laser tracer that are committed.

use crate::expectation::{Expectation, HeldOut, Number};
use crate::generators::{Case, Story, generated, words};
use crate::kinds::tracker_lm::tracer::{Run, simulate};
use crate::kinds::tracker_lm::tracer_run::{Defect, Measured};
use crate::kinds::tracker_lm::tracer_tables::tables;

/// All of them.
pub(crate) fn cases() -> Vec<Case> {
    vec![
        nothing(),
        beam_breaks(),
        backlash(),
        dead_path_jump(),
        mount_slip(),
        creep(),
        warm_stand(),
        glass_path(),
        air(),
        free_scale(),
        outside_bending(),
    ]
}

fn run_case(
    folder: &str,
    run: &Run,
    title: &'static str,
    truth: &str,
    expect: Expectation,
) -> Case {
    let measured = simulate(run);
    let truth = format!(
        "{truth} {} stations, {} off their nominal places by {} µm per coordinate; {} reflectors, \
         0.3 mm off theirs; {} angles; noise of a displacement {} µm.",
        run.n_stations,
        if run.declare_stations { "known to be" } else { "tacitly" },
        run.stations_off_mm * 1e3,
        run.n_mounts,
        run.n_angles,
        run.noise_mm * 1e3,
    );
    let story = Story { title, truth, expect };
    generated(&format!("tracker-lm/{folder}"), run.seed, tables(run, &measured), story)
}

/// Error on unseen ranges that the noise alone makes; the errors of an angle are taken out.
fn held_out(run: &Run) -> HeldOut {
    HeldOut { noise: run.noise_mm, at_most: 1.25 }
}

fn named(run: &Run, effect: &str) -> Expectation {
    Expectation {
        verdict: words(&["explained"]),
        effects: vec![words(&[effect])],
        nothing_else: true,
        held_out: Some(held_out(run)),
        ..Expectation::default()
    }
}

fn clean(run: &Run, measured: &Measured) -> Expectation {
    Expectation {
        verdict: words(&["nothing-missing", "noise-larger-than-declared"]),
        nothing_else: true,
        held_out: Some(held_out(run)),
        solve_numbers: errors_at_the_ends(measured),
        ..Expectation::default()
    }
}

/// Six standard uncertainties of the frame that stations known to 4 µm make over an arc of 180°:
/// 5 µm and 9 µrad, as found over many seeds.
const ERROR_TOL_MM: f64 = 0.030;
const ERROR_TOL_RAD: f64 = 54e-6;

/// Errors of the axis in the middle and at the end, relative to the first angle.
fn errors_at_the_ends(measured: &Measured) -> Vec<Number> {
    let because = "six standard uncertainties of the frame that the stations make".to_owned();
    let mut numbers = Vec::new();
    for step in [measured.steps.len() / 2, measured.steps.len() - 1] {
        let (displacement, rotation) = measured.errors[step];
        let at = format!("estimates.axis_errors.{step}");
        for (c, name) in ["x", "y", "z"].iter().enumerate() {
            numbers.push(Number {
                path: format!("{at}.e_{name}_mm"),
                value: displacement[c],
                tolerance: ERROR_TOL_MM,
                because: because.clone(),
            });
        }
        for (c, name) in ["a", "b", "c"].iter().enumerate() {
            numbers.push(Number {
                path: format!("{at}.e_{name}_rad"),
                value: rotation[c],
                tolerance: ERROR_TOL_RAD,
                because: because.clone(),
            });
        }
    }
    numbers
}

fn nothing() -> Case {
    let run = Run { n_angles: 19, one_tracer: true, ..Run::new(61) };
    let truth = "Nothing is wrong; one tracer takes one lock after the other.";
    let expect = clean(&run, &simulate(&run));
    run_case("nothing", &run, "Swivel head, nothing wrong", truth, expect)
}

fn beam_breaks() -> Case {
    let run = Run { n_angles: 19, missing: 0.12, station_dead_paths: true, ..Run::new(62) };
    let truth = "Nothing is wrong, but one reading in eight is missing; one dead path per station.";
    let expect = clean(&run, &simulate(&run));
    run_case("beam-breaks", &run, "Swivel head, readings missing", truth, expect)
}

fn backlash() -> Case {
    let defect = Defect::Backlash(12e-6, [0.0, 0.0015, 0.0]);
    let run = Run { n_angles: 13, both_ways: true, defect, ..Run::new(63) };
    let truth = "The drive has 12 µrad of play, and the bearing gives by 1.5 µm along the axis.";
    run_case("backlash", &run, "Swivel head with backlash", truth, named(&run, "backlash"))
}

fn dead_path_jump() -> Case {
    let defect = Defect::DeadPathJump(3, 1, 12, 0.006);
    let run = Run { n_angles: 19, defect, ..Run::new(64) };
    let truth = "The beam from S4 to R2 is lost before step 13 and found 6 µm off.";
    let expect = named(&run, "dead-path-jump");
    run_case("dead-path-jump", &run, "A beam lost and found again", truth, expect)
}

fn mount_slip() -> Case {
    let defect = Defect::MountSlip(2, 8, [0.004, 0.002, -0.003]);
    let run = Run { n_angles: 19, defect, ..Run::new(66) };
    let truth = "Reflector R3 slips by 5.4 µm in its nest before step 9.";
    let expect = named(&run, "mount-slip");
    run_case("mount-slip", &run, "A reflector that slips", truth, expect)
}

fn creep() -> Case {
    let defect = Defect::RangeDrift(0.012);
    let run = Run { n_angles: 19, one_tracer: true, defect, ..Run::new(71) };
    let truth = "The reading creeps by 12 µm over every lock, fast at first.";
    let expect = named(&run, "range-drift");
    run_case("range-drift", &run, "A reading that creeps after lock-on", truth, expect)
}

fn warm_stand() -> Case {
    let defect = Defect::StationDrift(2, [0.008, -0.006, 0.012]);
    let run = Run { n_angles: 19, defect, ..Run::new(72) };
    let truth = "The stand of S3 warms and moves by 15.6 µm, fast at first.";
    let expect = named(&run, "station-drift");
    run_case("station-drift", &run, "A stand that warms", truth, expect)
}

fn glass_path() -> Case {
    let defect = Defect::Incidence(0.012);
    let run = Run { n_angles: 19, defect, ..Run::new(73) };
    let truth = "The reflectors lengthen a beam at grazing incidence by 13 µm.";
    let expect = named(&run, "incidence");
    run_case("incidence", &run, "Reflectors with a path in glass", truth, expect)
}

fn air() -> Case {
    let defect = Defect::Temperature(-8e-6);
    let run = Run { n_angles: 19, record_air: true, defect, ..Run::new(74) };
    let truth = "The wavelength is not corrected: −8 ppm per kelvin of the air.";
    let expect = named(&run, "temperature");
    run_case("temperature", &run, "A wavelength that follows the air", truth, expect)
}

fn free_scale() -> Case {
    let run = Run {
        n_angles: 13,
        declare_stations: false,
        defect: Defect::RangeScale(60e-6),
        ..Run::new(69)
    };
    let truth = "The tracer's wavelength is 60 ppm off, and nothing in the case gives a length.";
    let expect = Expectation {
        verdict: words(&["nothing-missing"]),
        nothing_else: true,
        not_observable: words(&["range-scale", "backlash"]),
        ..Expectation::default()
    };
    run_case("free-scale", &run, "A wrong wavelength that cannot show", truth, expect)
}

fn outside_bending() -> Case {
    let run = Run { n_angles: 25, defect: Defect::Bending(3, 0.012), ..Run::new(70) };
    let truth = "The bracket of R4 bends by up to 12 µm under its weight as the head swivels.";
    let expect = Expectation {
        verdict: words(&["structure-remains"]),
        nothing_else: true,
        // Successive stops agree with each other more than the declared noise allows.
        structure: vec![words(&["order", "angle_deg"])],
        ..Expectation::default()
    };
    run_case("outside-bending", &run, "A bracket that bends", truth, expect)
}
