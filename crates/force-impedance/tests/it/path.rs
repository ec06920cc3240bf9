//! Runs along a path: cells, effects, what repeats and what does not.

use force_impedance::{ForceImpedanceError, PathModel, PathOptions, PathSample};
use model_discrepancy::{Closure, Model, Options, State, check_tangents, close_loop};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// The effects are linear: central differences leave round-off over a step, 2⁻⁵²·100/1e-4.
const DIFFERENCE_TOL: f64 = 1e-6;

const N_RUNS: u32 = 6;

/// Runs over 300 mm at 20, 40, 60 N, with noise of 1 N correlated by 0.5, and a repeated error.
fn runs(seed: u64, repeated_n: fn(f64, f64) -> f64) -> Vec<PathSample> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut samples = Vec::new();
    for run in 0..N_RUNS {
        let reference_n = 20.0 * f64::from(run % 3 + 1);
        let mut noise_n: f64 = rng.sample(StandardNormal);
        for i in 0..150_u32 {
            noise_n = 0.5 * noise_n + 0.75_f64.sqrt() * rng.sample::<f64, _>(StandardNormal);
            let path_mm = 2.0 * f64::from(i) + 0.3 * f64::from(run);
            samples.push(PathSample {
                time_s: 0.05 * f64::from(i) + 20.0 * f64::from(run),
                path_mm,
                force_n: reference_n + repeated_n(path_mm, reference_n) + noise_n,
                reference_n,
                run: run as usize,
            });
        }
    }
    samples
}

fn closed(samples: &[PathSample]) -> Closure {
    let model = PathModel::new(samples, &PathOptions::default()).unwrap();
    let covariates = model.covariates();
    close_loop(&model, &covariates, &Options { nested: false, ..Options::default() }).unwrap()
}

#[test]
fn tangents_agree_with_differences() {
    let model = PathModel::new(&runs(1, |_, _| 0.0), &PathOptions::default()).unwrap();
    let mut at = State::start(&model);
    assert!(check_tangents(&model, &at) < DIFFERENCE_TOL);
    for amplitude in &mut at.amplitudes {
        amplitude.fill(0.01);
    }
    assert!(check_tangents(&model, &at) < DIFFERENCE_TOL);
    for proposal in model.proposals() {
        assert!(check_tangents(&*proposal.model().unwrap(), &at) < DIFFERENCE_TOL);
    }
}

#[test]
fn an_error_that_repeats_at_a_place_is_named_with_its_size() {
    let bump = |path_mm: f64, _: f64| 8.0 * (-0.5 * ((path_mm - 200.0) / 15.0).powi(2)).exp();
    let closure = closed(&runs(2, bump));
    assert_eq!(closure.steps[0].effect, "path-repeatable", "{:?}", closure.steps);
    let at_200 = |name: &str| name[3..name.len() - 3].parse::<f64>().unwrap() - 200.0;
    let near = (closure.steps[0].parameters.iter())
        .min_by(|a, b| at_200(&a.name).abs().total_cmp(&at_200(&b.name).abs()));
    // Six runs with 1 N: 0.4 N, and what a coarse knot cuts off a bump of 15 mm.
    assert!((near.unwrap().value - 8.0).abs() < 2.0, "{near:?}");
}

#[test]
fn a_share_of_the_force_that_is_lost_at_a_place_is_named_first() {
    let loss = |path_mm: f64, force_n: f64| {
        -0.4 * force_n * (-0.5 * ((path_mm - 120.0) / 15.0_f64).powi(2)).exp()
    };
    let closure = closed(&runs(3, loss));
    let step = &closure.steps[0];
    assert_eq!(step.effect, "path-share", "{:?}", closure.steps);
    assert!(closure.after.held_out_rms < 0.6 * closure.before.held_out_rms);
}

#[test]
fn runs_with_nothing_in_common_give_nothing() {
    let named = (10..30).filter(|seed| !closed(&runs(*seed, |_, _| 0.0)).steps.is_empty());
    // Of twenty at 5 % each four or more are found once in sixty times.
    assert!(named.count() < 4);
}

#[test]
fn readings_outside_the_common_stretch_are_left_out() {
    let samples = runs(4, |_, _| 0.0);
    let model = PathModel::new(&samples, &PathOptions::default()).unwrap();
    // The last run begins at 1.5 mm, the first ends at 298 mm.
    let [from_mm, to_mm] = model.stretch_mm();
    // Sums of exact tenths, to round-off.
    assert!((from_mm - 1.5).abs() < 1e-12 && (to_mm - 298.0).abs() < 1e-12);
    let judged: usize = model.samples().map(<[usize]>::len).sum();
    assert!(judged < samples.len() && judged > samples.len() - 12, "{judged}");
}

#[test]
fn runs_over_different_parts_are_an_error() {
    let mut samples = runs(5, |_, _| 0.0);
    for sample in samples.iter_mut().filter(|s| s.run == 2) {
        sample.path_mm += 1000.0;
    }
    let error = PathModel::new(&samples, &PathOptions::default()).unwrap_err();
    assert!(matches!(error, ForceImpedanceError::NoCommonPath { runs: 6, .. }), "{error}");
}

#[test]
fn bad_readings_are_named_by_their_place() {
    let sound = runs(6, |_, _| 0.0);
    let judged = |samples: &[PathSample]| PathModel::new(samples, &PathOptions::default());
    let mut samples = sound.clone();
    samples[17].force_n = f64::NAN;
    let error = judged(&samples).unwrap_err();
    assert!(matches!(error, ForceImpedanceError::Sample { index: 17, .. }), "{error}");
    let mut samples = sound.clone();
    samples[9].time_s = samples[8].time_s;
    let error = judged(&samples).unwrap_err();
    assert!(matches!(error, ForceImpedanceError::TimeNotIncreasing { index: 9, .. }), "{error}");
    let error = judged(&sound[..3]).unwrap_err();
    assert!(matches!(error, ForceImpedanceError::TooFewSamples { got: 3, .. }), "{error}");
    assert!(judged(&[]).is_err());
}
