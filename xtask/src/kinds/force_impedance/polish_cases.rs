//! Simulated polishing runs that are committed.

use crate::expectation::{Expectation, Number};
use crate::generators::noise::Colour;
use crate::generators::{Case, Story, generated, named, nothing, words};
use crate::kinds::force_impedance::polish::{Flaw, Run, residuals_n, simulate};
use crate::kinds::force_impedance::polish_tables::{case_toml, log_csv};

/// Verdict where nothing is missing.
const QUIET: [&str; 1] = ["nothing-missing"];

/// All of them.
pub(crate) fn cases() -> Vec<Case> {
    vec![
        nothing_coloured(),
        axial_zero(),
        leg_gain(),
        head_weight(),
        spline_friction(),
        force_drift(),
        reference_delay(),
        air_temperature(),
        published_formula(),
        no_reference(),
        outside_curvature(),
        outside_humidity(),
    ]
}

fn run_case(
    folder: &str,
    run: &Run,
    title: &'static str,
    truth: &str,
    expect: Expectation,
) -> Case {
    let samples = simulate(run);
    let tables = vec![("case.toml", case_toml(run)), ("log.csv", log_csv(run, &samples))];
    let truth = format!(
        "{truth} The head follows a wavy surface in {} strips; the pad rubs with µ = {}; noise of \
         cells and reference {} N, {}.",
        run.n_segments,
        run.friction,
        run.noise_n,
        match run.colour {
            Colour::White => "white",
            Colour::Ar1(_) => "correlated from sample to sample",
            Colour::Pink => "1/f",
            Colour::HeavyTails => "Student's t with three degrees of freedom",
        }
    );
    generated(
        &format!("force-impedance/{folder}"),
        run.seed,
        tables,
        Story { title, truth, expect },
    )
}

/// Error of the force that the simulator's own statics find, to the digits of the table.
fn rms(run: &Run) -> Number {
    let residuals = residuals_n(run, &simulate(run));
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let n = residuals.len() as f64;
    Number {
        path: "estimates.contact_force.rms_error_n".to_owned(),
        value: (residuals.iter().map(|r| r * r).sum::<f64>() / n).sqrt(),
        tolerance: 5e-4,
        because: "the simulator's own statics; the table has three digits".to_owned(),
    }
}

fn nothing_coloured() -> Case {
    let run = Run { colour: Colour::Pink, declare_noise: false, ..Run::new(61) };
    let expect = Expectation { solve_numbers: vec![rms(&run)], ..nothing(&QUIET) };
    run_case("nothing-coloured", &run, "Nothing wrong, 1/f noise", "Nothing is wrong.", expect)
}

fn axial_zero() -> Case {
    let run = Run { flaw: Flaw::CellZero(3, 0.8), ..Run::new(62) };
    let truth = "The axial cell reads 0.8 N under no load.";
    let expect = Expectation { solve_numbers: vec![rms(&run)], ..named(&["leg-zero"]) };
    run_case("axial-zero", &run, "Zero of the axial cell", truth, expect)
}

fn leg_gain() -> Case {
    let run = Run { flaw: Flaw::CellGain(3, 0.03), ..Run::new(63) };
    let truth = "The axial cell reads 3 % high.";
    run_case("leg-gain", &run, "Axial cell reads 3 % high", truth, named(&["leg-gain"]))
}

fn head_weight() -> Case {
    let run = Run { flaw: Flaw::Weight(9.0), ..Run::new(64) };
    let truth = "The head is 9 N heavier than declared.";
    run_case("head-weight", &run, "Head 9 N heavier than declared", truth, named(&["head-weight"]))
}

fn spline_friction() -> Case {
    let run = Run { flaw: Flaw::Spline(0.6), ..Run::new(65) };
    let truth = "The spline rubs with 0.6 N against the way the head slides.";
    // Where the head turns round between two samples, nobody knows which way the spline rubs.
    let expect = Expectation {
        verdict: words(&["noise-larger-than-declared"]),
        ..named(&["spline-friction"])
    };
    run_case("spline-friction", &run, "Spline rubs with 0.6 N", truth, expect)
}

fn force_drift() -> Case {
    let run = Run { flaw: Flaw::Drift(0.9), colour: Colour::Ar1(0.6), ..Run::new(66) };
    let truth = "The axial cell drifts by 0.9 N during the run.";
    run_case("force-drift", &run, "Axial cell drifts", truth, named(&["force-drift"]))
}

fn reference_delay() -> Case {
    let run = Run { flaw: Flaw::Delay(0.02), ..Run::new(67) };
    let truth = "The reference is read 20 ms late, less than a sampling interval.";
    run_case("reference-delay", &run, "Reference 20 ms late", truth, named(&["delay"]))
}

fn air_temperature() -> Case {
    let run = Run { flaw: Flaw::Warmth(0.25), record_air: true, ..Run::new(72) };
    let truth = "The axial cell follows the temperature of the air, 0.25 N/K from 20 °C.";
    run_case("air-temperature", &run, "Axial cell follows the air", truth, named(&["temperature"]))
}

fn published_formula() -> Case {
    let run = Run { formula: "published", ..Run::new(68) };
    let truth = "Nothing is wrong, but the declared formula is that of the document, which knows \
                 neither friction nor weight; the weight hardly acts along the tool here.";
    let expect = named(&["contact-friction"]);
    run_case("published-formula", &run, "The published formula", truth, expect)
}

fn no_reference() -> Case {
    let run = Run {
        reference: false,
        declare_noise: false,
        flaw: Flaw::LengthZero(0, 0.02),
        ..Run::new(69)
    };
    let truth = "The sensor of leg 1 reads 20 µm too long; no reference instrument was there.";
    let expect = Expectation {
        verdict: words(&["explained"]),
        effects: vec![words(&["leg-zero"])],
        nothing_else: true,
        not_observable: words(&[
            "leg-gain",
            "head-weight",
            "spline-friction",
            "force-drift",
            "delay",
        ]),
        says: words(&["reference instrument"]),
        ..Expectation::default()
    };
    run_case("no-reference", &run, "No reference instrument", truth, expect)
}

fn outside_curvature() -> Case {
    let run = Run { flaw: Flaw::CellCurvature(1.2e-3), ..Run::new(70) };
    let truth = "The axial cell is not linear: it reads f·(1 + 0.0012·f). No effect in the catalogue \
                 says so.";
    let expect = Expectation {
        verdict: words(&["structure-remains"]),
        // A straight line through the curve, and its zero, are two names for parts of what is none: neither is
        // given, and that they are parts must be said.
        nothing_else: true,
        structure: vec![words(&["leg-gain"])],
        ..Expectation::default()
    };
    run_case("outside-curvature", &run, "Axial cell not linear", truth, expect)
}

fn outside_humidity() -> Case {
    let run = Run { flaw: Flaw::Humidity(0.08), ..Run::new(71) };
    let truth = "The axial cell follows the humidity of the air, 0.08 N per percent, which the table \
                 has as a column.";
    let expect = Expectation {
        verdict: words(&["explained"]),
        effects: vec![words(&["covariate:humidity_pct"])],
        nothing_else: true,
        ..Expectation::default()
    };
    run_case("outside-humidity", &run, "Axial cell follows humidity", truth, expect)
}
