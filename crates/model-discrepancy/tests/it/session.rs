//! What stands elsewhere from some reading on.

use model_discrepancy::{
    Course, LinearModel, Options, State, Verdict, clearest_courses, close_loop,
};
use nalgebra::{DMatrix, Point3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::linear_model::{normal, offer, parameter, scalars, set_base};

const N: usize = 60;
/// Series of noise that are looked at.
const SERIES: u64 = 400;
/// Of these, one in a hundred may show a session: more than 12 of 4 expected come once in a thousand.
const MOST_FALSE: usize = 12;
/// Loops that add something false beside it: one in twenty may, and the binomial law gives more than 12
/// of 100 once in a thousand.
const MOST_ADDED: usize = 12;
/// Loops whose intervals are counted, and the fewest that 95 % leaves but once in a thousand.
const LOOPS: u64 = 100;
const FEWEST_COVERED: usize = 87;

fn elapsed() -> Vec<f64> {
    (0..N).map(|i| i as f64).collect()
}

/// Readings with noise 1 about a zero that is fitted, with an even drift in the catalogue.
fn series(seed: u64, truth: impl Fn(usize) -> f64) -> LinearModel {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let data: Vec<f64> = (0..N).map(|i| truth(i) + normal(&mut rng)).collect();
    let mut model = scalars(&data, &[("drift", elapsed())]);
    set_base(&mut model, &["zero"], DMatrix::from_element(N, 1, 1.0));
    model
}

fn sessions(model: &LinearModel) -> Vec<Course> {
    let all = clearest_courses(model, &State::start(model), 0, &elapsed(), &[]);
    all.into_iter().filter(|course| matches!(course, Course::Session(_))).collect()
}

fn begun(i: usize, first: usize) -> f64 {
    f64::from(u8::from(i >= first))
}

#[test]
fn noise_hardly_ever_shows_a_session() {
    let shown = (0..SERIES).filter(|&seed| !sessions(&series(seed, |_| 0.0)).is_empty());
    assert!(shown.count() <= MOST_FALSE);
}

#[test]
fn an_even_drift_is_no_session() {
    for seed in 0..100 {
        let model = series(1000 + seed, |i| 0.3 * i as f64);
        assert_eq!(sessions(&model), []);
    }
}

#[test]
fn a_few_readings_far_off_at_the_end_are_no_session() {
    for seed in 0..50 {
        let model = series(2000 + seed, |i| 9.0 * begun(i, N - 2));
        let says = |course: &Course| {
            let subject = course.effect(&model, 0, &elapsed(), "s", ("mm", 1.0)).subject;
            subject.is_some_and(|s| s.contains(&(N - 2).to_string()))
        };
        assert!(!sessions(&model).iter().any(says));
    }
}

#[test]
fn a_session_that_no_column_says_is_named_with_its_first_reading_and_its_shift() {
    let truth = 6.0;
    let mut added = 0;
    let covered = (0..LOOPS).filter(|&seed| {
        let first = 12 + usize::try_from(seed * 7 % 36).unwrap();
        let mut model = series(3000 + seed, |i| truth * begun(i, first));
        for course in clearest_courses(&model, &State::start(&model), 0, &elapsed(), &[]) {
            offer(&mut model, &course, &elapsed(), "mm");
        }
        let closure = close_loop(&model, &[], &Options::default()).unwrap();
        let names: Vec<_> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
        assert_eq!(names[0], "session-shift", "{seed}: {names:?}");
        if names.len() > 1 || closure.verdict != Verdict::Explained {
            added += 1;
        }
        let shift = &closure.steps[0].parameters[0];
        assert_eq!(shift.unit, "mm");
        (shift.value - truth).abs() <= 1.96 * shift.std
    });
    let covered = covered.count();
    assert!(covered >= FEWEST_COVERED, "{covered}");
    assert!(added <= MOST_ADDED, "{added}");
}

/// Rows without times may be sorted: then what stands elsewhere is a place, and not a time.
#[test]
fn a_step_from_place_to_place_is_no_session_where_no_time_says_so() {
    let mut model = series(1, |i| 8.0 * begun(i, 30));
    let count = |model: &LinearModel, place: fn(usize) -> usize| {
        let places: Vec<_> = (0..N).map(|i| Some(Point3::new(place(i) as f64, 0.0, 0.0))).collect();
        let all = clearest_courses(model, &State::start(model), 0, &elapsed(), &places);
        all.iter().filter(|course| matches!(course, Course::Session(_))).count()
    };
    assert_eq!(count(&model, |i| i), 0);
    assert_eq!(count(&model, |i| i * 37 % N), 1);
    model.declared.effects[0].driver = Some("time_s".to_owned());
    assert_eq!(count(&model, |i| i), 1);
}

#[test]
fn amplitudes_are_those_of_the_drift() {
    let model = series(1, |i| 8.0 * begun(i, 30));
    let [course] = sessions(&model)[..] else { panic!("eight times the noise") };
    let effect = course.effect(&model, 0, &elapsed(), "s", ("µm", 1e3));
    assert_eq!(effect.subject.as_deref(), Some("from 30 on"));
    assert_eq!(effect.parameters.len(), 1);
    assert_eq!(effect.parameters[0].name, parameter("a0").name);
    assert_eq!(
        (effect.parameters[0].unit.as_str(), effect.parameters[0].report_factor),
        ("µm", 1e3)
    );
    assert_eq!(course.come(&[29.0, 30.0, 75.0]), [0.0, 1.0, 1.0]);
}

/// Places that come in an order of their own, so that every session reads all over the place.
fn scattered() -> Vec<Option<Point3<f64>>> {
    (0..N).map(|i| Some(Point3::new((i * 37 % N) as f64, 0.0, 0.0))).collect()
}

fn subjects(model: &LinearModel, places: &[Option<Point3<f64>>]) -> Vec<String> {
    let all = clearest_courses(model, &State::start(model), 0, &elapsed(), places);
    let of = |course: &Course| course.effect(model, 0, &elapsed(), "s", ("mm", 1.0)).subject;
    let sessions = all.iter().filter(|course| matches!(course, Course::Session(_)));
    sessions.filter_map(of).collect()
}

#[test]
fn a_session_in_between_has_its_first_and_its_last_reading() {
    let within = |i: usize| begun(i, 20) - begun(i, 42);
    for seed in 0..50 {
        let model = series(3000 + seed, |i| 8.0 * within(i));
        assert_eq!(subjects(&model, &scattered()), ["from 20 to 41"], "{seed}");
        // Where it stands for a place, or nothing says where it stands, it is none.
        for places in [Vec::new(), (0..N).map(|i| Some(Point3::new(i as f64, 0.0, 0.0))).collect()]
        {
            let all = subjects(&model, &places);
            assert!(all.iter().all(|subject| subject.ends_with(" on")), "{seed}: {all:?}");
        }
    }
}

#[test]
fn noise_hardly_ever_shows_a_session_in_between() {
    let shown = |seed: &u64| !subjects(&series(*seed, |_| 0.0), &scattered()).is_empty();
    assert!((0..SERIES).filter(shown).count() <= MOST_FALSE);
}

/// A reading far off takes its neighbours with it into a short session.
#[test]
fn one_reading_far_off_is_no_session_in_between() {
    for seed in 0..50 {
        let model = series(4000 + seed, |i| if i == 24 { 40.0 } else { 0.0 });
        let all = subjects(&model, &scattered());
        assert!(!all.iter().any(|subject| subject.contains(" to ")), "{seed}: {all:?}");
    }
}

/// Of what stands elsewhere in one group alone no other group tells anything.
#[test]
fn one_group_elsewhere_is_no_session() {
    let mut model = series(1, |i| 8.0 * (begun(i, 20) - begun(i, 40)));
    for (i, group) in model.declared.layout.observations.iter_mut().enumerate() {
        *group = i / 20;
    }
    let all = subjects(&model, &scattered());
    assert!(all.iter().all(|subject| subject.ends_with(" on")), "{all:?}");
}
