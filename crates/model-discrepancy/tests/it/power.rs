//! How often the loop is right, over many simulated data sets.

use model_discrepancy::{Closure, Options, Verdict, Visibility, assess, close_loop};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::linear_model::{body, coordinates, noise, points};

const SEEDS: u64 = 40;

/// Most of 40 trials in which an event of probability 0.05 is seen: mean 2, standard deviation
/// 1.4, plus three of them.
const MOST_OF_FIVE_PERCENT: usize = 6;

/// Noise of one coordinate, mm.
const SIGMA_MM: f64 = 0.01;

fn simulate(n: usize, phi: f64, add: impl Fn(&Vector3<f64>, f64) -> Vector3<f64>) -> Vec<Closure> {
    (0..SEEDS)
        .map(|seed| {
            let points = points(n, 1000 + seed);
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut errors = noise(n, SIGMA_MM, phi, &mut rng);
            for (i, (e, p)) in errors.iter_mut().zip(&points).enumerate() {
                *e += add(p, i as f64 / (n - 1) as f64 - 0.5);
            }
            let options = Options { nested: false, ..Options::default() };
            close_loop(&body(&points, &errors), &coordinates(&points), &options)
                .expect("a plate of points can be judged")
        })
        .collect()
}

fn names(closure: &Closure) -> Vec<&str> {
    let mut names: Vec<_> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
    names.sort_unstable();
    names
}

fn how_many(closures: &[Closure], is: impl Fn(&Closure) -> bool) -> usize {
    closures.iter().filter(|c| is(c)).count()
}

#[test]
fn adds_nothing_where_nothing_is_missing() {
    for (n, phi) in [(12, 0.0), (24, 0.0), (24, 0.5), (24, 0.8), (40, 0.6)] {
        let closures = simulate(n, phi, |_, _| Vector3::zeros());
        let added = how_many(&closures, |c| !c.steps.is_empty());
        assert!(added <= MOST_OF_FIVE_PERCENT, "n = {n}, phi = {phi}: {added} of {SEEDS}");
    }
}

#[test]
fn adds_nothing_to_one_over_f_noise() {
    let n = 24;
    let mut added = 0;
    for seed in 0..SEEDS {
        let points = points(n, 2000 + seed);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        // Memories of 1, 4, 16, 64 and 256 points, of equal size.
        let mut errors = vec![Vector3::zeros(); n];
        for phi in [0.368, 0.779, 0.939, 0.984, 0.996] {
            let part = noise(n, SIGMA_MM, phi, &mut rng);
            errors.iter_mut().zip(part).for_each(|(e, p)| *e += p);
        }
        let options = Options { nested: false, ..Options::default() };
        let closure = close_loop(&body(&points, &errors), &coordinates(&points), &options)
            .expect("a plate of points can be judged");
        added += usize::from(!closure.steps.is_empty());
    }
    assert!(added <= MOST_OF_FIVE_PERCENT, "{added} of {SEEDS}");
}

#[test]
fn names_the_effect_that_is_there() {
    type Add = fn(&Vector3<f64>, f64) -> Vector3<f64>;
    let effects: [(&[&str], Add); 5] = [
        (&["scale"], |p, _| p * 6e-5),
        (&["shear"], |p, _| Vector3::new(p.y, p.x, 0.0) * 1e-4),
        (&["drift"], |_, t| Vector3::new(0.08, 0.0, 0.02) * t),
        (&["sag"], |p, _| Vector3::new(0.0, 0.0, -8e-7 * p.x * p.x)),
        (&["drift", "scale"], |p, t| Vector3::new(0.08, 0.0, 0.02) * t + p * 6e-5),
    ];
    for (truth, add) in effects {
        let closures = simulate(24, 0.0, add);
        let right = how_many(&closures, |c| names(c) == truth);
        assert!(right + MOST_OF_FIVE_PERCENT >= closures.len(), "{truth:?}: {right} of {SEEDS}");
    }
}

#[test]
fn names_the_reading_that_is_bad() {
    let closures =
        simulate(
            24,
            0.0,
            |_, t| {
                if t > 0.49 { Vector3::new(0.1, 0.05, 0.0) } else { Vector3::zeros() }
            },
        );
    let right =
        how_many(&closures, |c| c.steps.len() == 1 && c.steps[0].subject.as_deref() == Some("P23"));
    assert!(right + MOST_OF_FIVE_PERCENT >= closures.len(), "{right} of {SEEDS}");
}

#[test]
fn is_not_sure_of_a_name_for_what_the_catalogue_lacks() {
    type Add = fn(&Vector3<f64>, f64) -> Vector3<f64>;
    let strange: [Add; 3] = [
        |p, _| Vector3::new(0.1 * (p.x / 400.0).powi(3), 0.0, 0.0),
        |p, _| Vector3::new(0.03 * (p.x / 40.0).sin(), 0.0, 0.0),
        // A scale that doubles while the points are measured is no scale.
        |p, t| p * 2e-4 * (1.0 + 0.7 * t),
    ];
    for add in strange {
        let closures = simulate(40, 0.0, add);
        let sure = how_many(&closures, |c| c.verdict == Verdict::Explained);
        assert!(sure <= MOST_OF_FIVE_PERCENT, "{sure} of {SEEDS}");
    }
}

/// Fewest of 40 trials in which an event of probability 0.9 is seen: mean 36, standard deviation
/// 1.9, less three of them.
const FEWEST_OF_NINE_TENTHS: usize = 30;

/// Each of the sizes that a design states, put into the very data by which it was stated.
#[test]
fn a_size_that_is_stated_is_named() {
    let n = 24;
    let named = |seed: u64| {
        let points = points(n, 3000 + seed);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut errors = noise(n, SIGMA_MM, 0.0, &mut rng);
        let options = Options { nested: false, ..Options::default() };
        let assessed = assess(&body(&points, &errors), &options).unwrap();
        let scale = assessed.iter().find(|a| a.effect == "scale").unwrap();
        let Visibility::Visible { detectable, .. } = &scale.sight else { panic!("it is seen") };
        let size = detectable[0].1;
        for (e, p) in errors.iter_mut().zip(&points) {
            *e += p * size;
        }
        let closure = close_loop(&body(&points, &errors), &coordinates(&points), &options).unwrap();
        names(&closure) == ["scale"]
    };
    let hits = (0..SEEDS).filter(|&seed| named(seed)).count();
    assert!(hits >= FEWEST_OF_NINE_TENTHS, "{hits} of {SEEDS}");
}
