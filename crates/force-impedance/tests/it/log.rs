//! Logs: forces, tangents, effects found, effects not found, what cannot be separated.

use force_impedance::{
    ForceFormula, ForceImpedanceError, Head, HeadGeometry, HeadLimits, LogModel, LogOptions,
    solve_log,
};
use model_discrepancy::{
    Closure, Covariate, Model, Options, Quantity, State, Verdict, check_tangents, close_loop,
};

use crate::log_rig::{Faults, Run, record};
use crate::usual_head::{GEOMETRY, head};

/// What central differences of a smooth function leave, relative to its largest derivative.
const DIFFERENCE_TOL: f64 = 1e-6;

fn closed(run: &Run, options: &LogOptions) -> Closure {
    let samples = record(run);
    let model = LogModel::new(&head(), &samples, options, &[]).unwrap();
    let covariates = model.covariates(&samples);
    close_loop(&model, &covariates, &Options { nested: false, ..Options::default() }).unwrap()
}

/// Effect, its parameter as reported, and every name of the class.
fn first(closure: &Closure) -> (String, f64, Vec<String>) {
    let step = &closure.steps[0];
    let mut class = step.indistinguishable_from.clone();
    class.push(step.effect.clone());
    (step.effect.clone(), step.parameters[0].value, class)
}

#[test]
fn without_faults_or_noise_the_forces_agree() {
    let run = Run { noise_n: 0.0, n_samples: 300, ..Run::default() };
    for force in solve_log(&head(), &record(&run), ForceFormula::FullBalance).unwrap() {
        assert!(force.residual_n.unwrap().abs() < 1e-9);
        assert!(force.consistency_mm.abs() < 1e-10);
        assert!((force.preload_n - 300.0 / 3f64.sqrt()).abs() < 30.0);
    }
}

#[test]
fn tangents_agree_with_differences_and_with_the_rig() {
    let samples = record(&Run { n_samples: 600, ..Run::default() });
    let warm = Covariate::recorded(
        "air_c",
        Quantity::Temperature,
        (0..600).map(|i| 19.0 + 0.01 * f64::from(i)).collect(),
    );
    for formula in [ForceFormula::FullBalance, ForceFormula::Published] {
        let options = LogOptions { formula, ..LogOptions::default() };
        let model =
            LogModel::new(&head(), &samples, &options, std::slice::from_ref(&warm)).unwrap();
        let mut at = State::start(&model);
        let worst = check_tangents(&model, &at);
        assert!(worst < DIFFERENCE_TOL, "{formula:?}: {worst:e}");
        for (effect, amplitude) in model.declared().effects.iter().zip(&mut at.amplitudes) {
            amplitude[0] = 0.3 / effect.parameters[0].report_factor;
        }
        let worst = check_tangents(&model, &at);
        assert!(worst < DIFFERENCE_TOL, "{formula:?}: {worst:e}");
        for proposal in model.proposals() {
            assert!(check_tangents(&*proposal.model().unwrap(), &at) < DIFFERENCE_TOL);
        }
    }
}

/// The course of a force that comes to rest is that of every block, also of those that are proposed.
#[test]
fn proposals_of_a_model_with_a_course_fit_their_blocks() {
    let mut samples = record(&Run { n_samples: 600, ..Run::default() });
    for (i, sample) in samples.iter_mut().enumerate() {
        let come = -(-(i as f64) / 60.0).exp_m1();
        sample.reference_n = sample.reference_n.map(|n| n + 5.0 * come);
    }
    let model = LogModel::new(&head(), &samples, &LogOptions::default(), &[]).unwrap();
    let subjects = || model.declared().effects.iter().filter_map(|e| e.subject.as_deref());
    assert!(subjects().any(|subject| subject == "settling"));
    for proposal in model.proposals() {
        let extended = &*proposal.model().unwrap();
        // Infinite where they do not fit.
        let worst = check_tangents(extended, &State::start(extended));
        assert!(worst.is_finite(), "{}", proposal.text);
    }
}

/// The residual that a fault makes in the rig is what its effect takes away again.
#[test]
fn every_effect_takes_away_what_its_fault_makes() {
    let one = |i: usize, value: f64| std::array::from_fn(|k| if k == i { value } else { 0.0 });
    let mut cases = vec![
        ("head-weight", 3.0, Faults { weight_n: 3.0, ..Faults::default() }),
        ("spline-friction", 2.0, Faults { spline_n: 2.0, ..Faults::default() }),
        ("force-drift", 2.0, Faults { drift_n: 2.0, ..Faults::default() }),
        ("delay", 0.02, Faults { delay_s: 0.02, ..Faults::default() }),
    ];
    for i in 0..4 {
        cases.push(("leg-zero", 1.0, Faults { cell_zero_n: one(i, 1.0), ..Faults::default() }));
        cases.push(("leg-zero", 0.1, Faults { length_zero_mm: one(i, 0.1), ..Faults::default() }));
        cases.push(("leg-gain", 0.02, Faults { cell_gain: one(i, 0.02), ..Faults::default() }));
    }
    for (id, size, faults) in cases {
        let run = Run { noise_n: 0.0, n_samples: 1000, faults, ..Run::default() };
        let model = LogModel::new(&head(), &record(&run), &LogOptions::default(), &[]).unwrap();
        let declared = State::start(&model);
        let before = model.residuals(&declared).norm();
        let after = (0..model.declared().effects.len())
            .filter(|e| model.declared().effects[*e].id == id)
            .map(|e| {
                let mut at = declared.clone();
                at.amplitudes[e][0] = size;
                model.residuals(&at).norm()
            })
            .fold(f64::INFINITY, f64::min);
        // Friction turns round within a block, a length's zero is not linear to the last digit.
        let share = match id {
            "spline-friction" => 0.15,
            "delay" => 0.02,
            _ => 0.005,
        };
        assert!(after < share * before, "{id} {faults:?}: {before} {after}");
    }
}

#[test]
fn coloured_noise_without_a_fault_adds_nothing() {
    for seed in 0..6 {
        for colour in [0.0, 0.9] {
            let closure = closed(&Run { colour, seed, ..Run::default() }, &LogOptions::default());
            assert!(closure.steps.is_empty(), "{:?}", closure.steps);
        }
    }
}

#[test]
fn faults_are_named_with_their_size() {
    let cases = [
        ("head-weight", 4.0, 0.3, Faults { weight_n: 4.0, ..Faults::default() }),
        ("spline-friction", 1.0, 0.2, Faults { spline_n: 1.0, ..Faults::default() }),
        ("delay", 30.0, 3.0, Faults { delay_s: 0.030, ..Faults::default() }),
        ("force-drift", 1.5, 0.2, Faults { drift_n: 1.5, ..Faults::default() }),
        ("leg-gain", 3.0, 0.3, Faults { cell_gain: [0.0, 0.0, 0.0, 0.03], ..Faults::default() }),
        ("leg-zero", 2.0, 0.3, Faults { cell_zero_n: [2.0, 0.0, 0.0, 0.0], ..Faults::default() }),
    ];
    for (id, size, tolerance, faults) in cases {
        let closure =
            closed(&Run { faults, colour: 0.5, ..Run::default() }, &LogOptions::default());
        let (effect, value, class) = first(&closure);
        assert!(class.iter().any(|name| name.starts_with(id)), "{id}: {class:?}");
        if effect == id {
            assert!((value - size).abs() < tolerance, "{id}: {value}");
        }
        assert_eq!(closure.steps.len(), 1, "{id}: {:?}", closure.steps);
        assert!(closure.after.held_out_rms < 0.8 * closure.before.held_out_rms, "{id}");
    }
}

/// The whole weight of a head that nobody declared, nor where it is.
#[test]
fn a_weight_that_was_not_declared_is_named_with_its_place() {
    let bare = HeadGeometry {
        weight_n: 0.0,
        center_of_gravity_mm: GEOMETRY.plane_to_joint_mm,
        ..GEOMETRY
    };
    let bare = Head::new(bare, HeadLimits::wide(&bare)).unwrap();
    let samples = record(&Run { colour: 0.5, ..Run::default() });
    let model = LogModel::new(&bare, &samples, &LogOptions::default(), &[]).unwrap();
    let worst = check_tangents(&model, &State::start(&model));
    // Residuals of tens of newtons instead of a few: their differences lose a digit more of round-off.
    assert!(worst < 2.0 * DIFFERENCE_TOL, "{worst:e}");
    let covariates = model.covariates(&samples);
    let options = Options { nested: false, ..Options::default() };
    let closure = close_loop(&model, &covariates, &options).unwrap();
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
    assert_eq!(closure.steps[0].effect, "head-weight");
    let moment_nmm = GEOMETRY.weight_n * GEOMETRY.center_of_gravity_mm;
    for (found, truth) in closure.steps[0].parameters.iter().zip([GEOMETRY.weight_n, moment_nmm]) {
        assert!((found.value - truth).abs() < 4.0 * found.std, "{found:?} {truth}");
    }
}

#[test]
fn the_published_formula_lacks_friction_and_weight() {
    let options = LogOptions { formula: ForceFormula::Published, ..LogOptions::default() };
    let closure = closed(&Run::default(), &options);
    let names: Vec<&str> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
    assert!(names.contains(&"contact-friction"), "{names:?}");
    assert!(names.contains(&"head-weight"), "{names:?}");
    let mu = closure.steps.iter().find(|s| s.effect == "contact-friction").unwrap();
    assert!((mu.parameters[0].value - 0.15).abs() < 0.01, "{:?}", mu.parameters);
}

/// Without a reference, only the lengths have a second opinion, and only of their common part.
#[test]
fn without_a_reference_forces_cannot_be_judged() {
    let faults = Faults { length_zero_mm: [0.05, 0.0, 0.0, 0.0], ..Faults::default() };
    let run = Run { with_reference: false, faults, ..Run::default() };
    let samples = record(&run);
    let model = LogModel::new(&head(), &samples, &LogOptions::default(), &[]).unwrap();
    assert_eq!(model.declared().layout.unit, "mm");
    let covariates = model.covariates(&samples);
    let closure = close_loop(&model, &covariates, &Options::default()).unwrap();
    for id in ["head-weight", "spline-friction", "force-drift", "delay", "leg-gain [force, axial]"]
    {
        let hidden = closure.not_observable.iter().find(|n| n.effect.starts_with(id));
        assert!(hidden.is_some(), "{id}: {:?}", closure.not_observable);
    }
    let weight = closure.not_observable.iter().find(|n| n.effect == "head-weight").unwrap();
    assert!(weight.separate_by.as_ref().unwrap().contains("reference instrument"));
    let (_, _, class) = first(&closure);
    assert!(class.iter().any(|name| name.starts_with("leg-zero")), "{class:?}");
    assert_ne!(closure.verdict, Verdict::NothingMissing);
}

#[test]
fn unusable_logs_are_refused() {
    let head = head();
    let samples = record(&Run { n_samples: 40, ..Run::default() });
    let solve = |s: &[force_impedance::LogSample]| solve_log(&head, s, ForceFormula::FullBalance);
    assert!(matches!(solve(&[]), Err(ForceImpedanceError::TooFewSamples { .. })));
    let mut bad = samples.clone();
    bad[7].cells_n[2] = f64::NAN;
    let e = solve(&bad).unwrap_err();
    assert_eq!(e.to_string(), "sample 8: load cell 3 (counted from 1) is not finite");
    let mut bad = samples.clone();
    bad[9].time_s = bad[8].time_s;
    assert!(matches!(solve(&bad), Err(ForceImpedanceError::TimeNotIncreasing { index: 9, .. })));
    let mut bad = samples.clone();
    bad[3].reference_n = None;
    assert!(matches!(solve(&bad), Err(ForceImpedanceError::PartialReference { .. })));
    let mut bad = samples.clone();
    bad[3].lengths_mm = [0.0; 4];
    assert!(matches!(solve(&bad), Err(ForceImpedanceError::Sample { index: 3, .. })));
    let new = |s: &[force_impedance::LogSample], c: &[Covariate]| {
        LogModel::new(&head, s, &LogOptions::default(), c)
    };
    assert!(new(&samples[..5], &[]).is_err());
    let short = Covariate::recorded("a", Quantity::Other, vec![1.0]);
    assert!(matches!(new(&samples, &[short]), Err(ForceImpedanceError::CovariateLength { .. })));
}

/// The noise of a force is the root sum of squares of what each cell adds to it, and of the reference.
#[test]
fn the_noise_of_a_force_is_that_of_its_cells() {
    /// Differences of forces of 400 N that differ by about one.
    const TOL: f64 = 1e-9;
    let samples = record(&Run { n_samples: 12, ..Run::default() });
    for formula in [ForceFormula::FullBalance, ForceFormula::Published] {
        let solved = |samples: &[_]| solve_log(&head(), samples, formula).unwrap();
        let before = solved(&samples);
        let mut squares = vec![0.0; samples.len()];
        for cell in 0..4 {
            let mut more = samples.clone();
            for sample in &mut more {
                sample.cells_n[cell] += 1.0;
            }
            for (k, more) in solved(&more).iter().enumerate() {
                squares[k] += (more.normal_n - before[k].normal_n).powi(2);
            }
        }
        let mut alone = samples.clone();
        for sample in &mut alone {
            sample.reference_n = None;
        }
        for ((with, without), square) in before.iter().zip(&solved(&alone)).zip(&squares) {
            assert!((without.noise_gain - square.sqrt()).abs() < TOL, "{formula:?}");
            assert!((with.noise_gain - (square + 1.0).sqrt()).abs() < TOL, "{formula:?}");
        }
    }
}

/// With a reference, what an effect adds to the force is what it adds to the residual; a delay is of
/// the reference and adds nothing.
#[test]
fn corrections_are_what_effects_add_to_the_residual() {
    // Round-off of forces of 400 N.
    const TOL_N: f64 = 1e-11;
    let samples = record(&Run { n_samples: 600, ..Run::default() });
    for formula in [ForceFormula::FullBalance, ForceFormula::Published] {
        let options = LogOptions { formula, ..LogOptions::default() };
        let model = LogModel::new(&head(), &samples, &options, &[]).unwrap();
        let start = State::start(&model);
        for (k, effect) in model.declared().effects.iter().enumerate() {
            let mut at = start.clone();
            at.amplitudes[k][0] = 0.3 / effect.parameters[0].report_factor;
            let mut added_n = model.residuals(&start) - model.residuals(&at);
            if effect.id == "delay" {
                added_n.fill(0.0);
            }
            for (found, expected) in model.force_corrections_n(&at).iter().zip(&added_n) {
                assert!((found - expected).abs() < TOL_N, "{}: {found} {expected}", effect.id);
            }
        }
    }
}
