//! What shows beside what was found.

use model_discrepancy::{Course, LinearModel, Shown, Sought, State};
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::linear_model::{normal, push, scalars};

const N: usize = 60;
const TIME_CONSTANT: f64 = 6.0;
/// Effects of the catalogue.
const DRIFT: usize = 0;
const WARM: usize = 1;

fn elapsed() -> Vec<f64> {
    (0..N).map(|i| i as f64).collect()
}

/// A temperature that rises and falls as the day does.
fn warmth() -> Vec<f64> {
    elapsed().iter().map(|t| (t / 9.0).sin()).collect()
}

/// Readings with noise 1, an even drift and a temperature in the catalogue.
fn series(truth: impl Fn(f64, f64) -> f64) -> LinearModel {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let pairs = elapsed().into_iter().zip(warmth());
    let data: Vec<f64> = pairs.map(|(t, warm)| truth(t, warm) + normal(&mut rng)).collect();
    scalars(&data, &[("drift", elapsed()), ("temperature", warmth())])
}

fn found(model: &LinearModel, amplitudes: &[(usize, f64)]) -> State {
    let mut at = State::start(model);
    for &(effect, size) in amplitudes {
        at.amplitudes[effect] = DVector::from_element(1, size);
    }
    at
}

/// The model with what was shown at the end of its catalogue.
fn with(model: &LinearModel, shown: &Shown) -> LinearModel {
    let mut all = model.clone();
    for (drift, course) in &shown.courses {
        let effect = course.effect(model, *drift, &elapsed(), "s", ("mm", 1.0));
        push(&mut all, effect, DMatrix::from_vec(N, 1, course.come(&elapsed())));
    }
    all
}

#[test]
fn a_course_shows_as_it_is_beside_what_hid_it() {
    let elapsed = elapsed();
    let sought = Sought { drifts: vec![DRIFT], elapsed: &elapsed, ..Sought::default() };
    let comes_to_rest = |t: f64| 12.0 * -(-t / TIME_CONSTANT).exp_m1();
    let model = series(|t, warm| comes_to_rest(t) + 40.0 * warm);
    let at_first = Shown::of(&model, &State::start(&model), &sought);
    // Farthest from the true course, as a share of all that it comes to.
    let off = |shown: &Shown| {
        let courses = shown.courses.iter().map(|(_, course)| course);
        let all = courses.filter(|course| matches!(course, Course::Settling(_)));
        let away = |course: &Course| {
            let come = course.come(&elapsed);
            let of = |(c, t): (&f64, &f64)| (c - comes_to_rest(*t) / 12.0).abs();
            come.iter().zip(&elapsed).map(of).fold(0.0, f64::max)
        };
        all.map(away).fold(f64::INFINITY, f64::min)
    };
    let model = with(&model, &at_first);
    let there = at_first.beside(&model, &found(&model, &[(WARM, 40.0)]), &sought);
    // 12 over noise 1: the time constant of sixty readings to about a tenth, and a tenth of it moves the
    // course by 0.1/e; three standard deviations.
    assert!(off(&there) < 0.12, "{there:?}");
    assert!(off(&at_first) > 2.0 * off(&there), "{at_first:?}");
}

#[test]
fn where_nothing_was_found_nothing_else_is_shown() {
    let elapsed = elapsed();
    let sought = Sought { drifts: vec![DRIFT], elapsed: &elapsed, ..Sought::default() };
    let model = series(|t, _| 12.0 * -(-t / TIME_CONSTANT).exp_m1());
    let at_first = Shown::of(&model, &State::start(&model), &sought);
    assert_eq!(at_first.effects(), 1);
    let model = with(&model, &at_first);
    assert_eq!(at_first.beside(&model, &State::start(&model), &sought), at_first);
}

/// A drift of three standard deviations of a reading may as well come to rest, or all at once.
#[test]
fn a_drift_that_was_found_has_its_likeliest_rivals() {
    let elapsed = elapsed();
    let model = series(|t, _| 0.05 * t);
    let timed = {
        let mut model = model;
        model.declared.effects[DRIFT].driver = Some("time_s".to_owned());
        model
    };
    let sought = Sought { drifts: vec![DRIFT], elapsed: &elapsed, ..Sought::default() };
    let at_first = Shown::of(&timed, &State::start(&timed), &sought);
    assert!(!at_first.courses.iter().any(|(_, course)| matches!(course, Course::Session(_))));
    let model = with(&timed, &at_first);
    let there = at_first.beside(&model, &found(&model, &[(DRIFT, 0.05)]), &sought);
    assert!(
        matches!(there.courses[..], [(DRIFT, Course::Settling(_)), (DRIFT, Course::Session(_))]),
        "{there:?}"
    );
    // Found again, they are the same, so that the loop comes to an end.
    let model = with(&timed, &there);
    assert_eq!(there.beside(&model, &found(&model, &[(DRIFT, 0.05)]), &sought), there);
}
