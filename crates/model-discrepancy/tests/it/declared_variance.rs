//! Readings that are all off by as much: a memory that explains them has more variance than declared.

use model_discrepancy::{Options, close_loop};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::linear_model::{effect, normal, push, scalars};

const READINGS: usize = 48;
/// Standard deviations by which all are off: of the mean of that many, 24.
const OFF: f64 = 3.4;
const TRIALS: u64 = 100;
/// Of 100 where one in two hundred is missed, three and more are once in sixty; without the declared
/// variance eight are.
const MOST_MISSED: usize = 2;

fn is_named(seed: u64, sigma_declared: bool) -> bool {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let data: Vec<f64> = (0..READINGS).map(|_| OFF + normal(&mut rng)).collect();
    let mut model = scalars(&data, &[]);
    model.declared.layout.sigma_declared = sigma_declared;
    push(&mut model, effect("offset", 1), DMatrix::from_element(READINGS, 1, 1.0));
    // Beside others, which share the level.
    for k in 1..10 {
        let wave = |i: usize, _| (0.37 * (k * i) as f64 + k as f64).sin();
        push(&mut model, effect(&format!("wave-{k}"), 1), DMatrix::from_fn(READINGS, 1, wave));
    }
    let options = Options { nested: false, ..Options::default() };
    let closure = close_loop(&model, &[], &options).expect("a sound model");
    closure.steps.iter().any(|step| step.effect == "offset")
}

#[test]
fn a_common_offset_is_no_memory_of_the_declared_variance() {
    let missed = |declared| (0..TRIALS).filter(|&seed| !is_named(seed, declared)).count();
    let (declared, found) = (missed(true), missed(false));
    assert!(declared <= MOST_MISSED, "{declared} of {TRIALS}");
    assert!(
        found > declared,
        "{found} of {TRIALS} where nothing is declared, {declared} where it is"
    );
}
