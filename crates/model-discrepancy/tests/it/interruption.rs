//! Drifts that break off and go on elsewhere.

use model_discrepancy::{
    Interruption, LinearModel, Options, State, Verdict, clearest_interruption, close_loop,
};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::linear_model::{normal, scalars};

const N: usize = 60;
/// Series of 200 without a break that may show one: one in a thousand is let pass, and the law of small
/// numbers gives more than 3 for 0.2 less than once in ten thousand.
const MOST_FALSE: usize = 3;
/// Reading after which the series broke off.
const LAST: usize = 33;

fn elapsed() -> Vec<f64> {
    (0..N).map(|i| i as f64).collect()
}

/// Readings with noise 1 about a zero that is fitted, with an even drift in the catalogue.
fn series(seed: u64, truth: impl Fn(f64) -> f64) -> LinearModel {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let data: Vec<f64> = elapsed().iter().map(|&t| truth(t) + normal(&mut rng)).collect();
    scalars(&data, &[("drift", elapsed())])
}

fn found(model: &LinearModel) -> Option<Interruption> {
    clearest_interruption(model, &State::start(model), 0, &elapsed())
}

/// A rate, a pause in which the zero moved by −6, and another rate.
fn interrupted(t: f64) -> f64 {
    let pause = LAST as f64 + 0.5;
    0.6 * t + if t > pause { -6.0 - 0.5 * (t - pause) } else { 0.0 }
}

/// The model with the break in its catalogue.
fn offered(mut model: LinearModel, found: Interruption) -> LinearModel {
    let courses = found.courses(&elapsed());
    model.tangents.push(DMatrix::from_fn(N, courses.len(), |row, k| -courses[k][row]));
    let effect = found.effect(&model.declared.effects[0], "in the pause");
    model.declared.effects.push(effect);
    model
}

#[test]
fn an_even_drift_shows_no_break() {
    let wrong = (0..200).filter(|&seed| found(&series(seed, |t| 0.5 * t)).is_some());
    assert!(wrong.count() <= MOST_FALSE);
}

#[test]
fn a_break_is_found_and_named_with_its_jump() {
    for seed in 0..10 {
        let model = series(400 + seed, interrupted);
        let found = found(&model).expect("six times the noise");
        let (last, next) = found.between(&elapsed()).unwrap();
        assert_eq!(next, last + 1);
        assert!(last.abs_diff(LAST) <= 2, "{last}");
        let closure = close_loop(&offered(model, found), &[], &Options::default()).unwrap();
        let [step] = &closure.steps[..] else { panic!("{:?}", closure.steps) };
        assert_eq!(step.subject.as_deref(), Some("interrupted"));
        assert_eq!(closure.verdict, Verdict::Explained);
        for (parameter, truth) in step.parameters.iter().zip([0.6, -6.0, -0.5]) {
            assert!((parameter.value - truth).abs() < 4.0 * parameter.std + 0.5, "{parameter:?}");
        }
    }
}

#[test]
fn a_break_that_nothing_shows_does_not_take_the_place_of_an_even_drift() {
    let made_up = found(&series(400, interrupted)).unwrap();
    for seed in 0..20 {
        let model = offered(series(500 + seed, |t| 0.5 * t), made_up);
        let closure = close_loop(&model, &[], &Options::default()).unwrap();
        let named: Vec<_> =
            closure.steps.iter().map(|s| (&*s.effect, s.subject.as_deref())).collect();
        assert_eq!(named, [("drift", None)], "{:?}", closure.verdict);
    }
}

#[test]
fn a_series_too_short_for_two_sides_has_no_break() {
    let short: Vec<f64> = (0..7).map(f64::from).collect();
    let model = scalars(&[0.0, 0.1, 0.2, 9.0, 9.1, 9.2, 9.3], &[("drift", short.clone())]);
    assert_eq!(clearest_interruption(&model, &State::start(&model), 0, &short), None);
}
