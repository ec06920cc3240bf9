//! A stretch of readings that scatters more than all others.

use model_discrepancy::{Closure, LinearModel, Options, Verdict, close_loop};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::linear_model::{normal, scalars, set_base};

const READINGS: usize = 60;
const STRETCH: std::ops::Range<usize> = 20..34;
const TIMES: f64 = 20.0;
const TRIALS: u64 = 100;
/// Of a hundred stretches of fourteen one in twenty has its middle or its mean elsewhere.
const FOUND: usize = 85;

/// A level with noise of unknown size, `times` as large in the stretch.
fn level(seed: u64, times: f64) -> LinearModel {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let data: Vec<f64> = (0..READINGS)
        .map(|i| normal(&mut rng) * if STRETCH.contains(&i) { times } else { 1.0 })
        .collect();
    let mut model = scalars(&data, &[]);
    set_base(&mut model, &["level"], DMatrix::from_element(READINGS, 1, 1.0));
    model.declared.layout.sigma_declared = false;
    model
}

fn closed(seed: u64, times: f64) -> Closure {
    close_loop(&level(seed, times), &[], &Options::default()).expect("a level is determined")
}

fn scatters(closure: &Closure) -> bool {
    closure.remaining.iter().any(|left| left.shape.contains("scatter"))
}

#[test]
fn what_scatters_twenty_times_as_much_in_one_stretch_is_no_noise() {
    let found: Vec<Closure> =
        (0..TRIALS).map(|seed| closed(seed, TIMES)).filter(scatters).collect();
    assert!(found.len() >= FOUND, "{} of {TRIALS}", found.len());
    assert!(found.iter().all(|closure| closure.verdict == Verdict::StructureRemains));
}

#[test]
fn noise_alone_has_no_such_stretch() {
    assert!(!(0..TRIALS).any(|seed| scatters(&closed(seed, 1.0))));
}
