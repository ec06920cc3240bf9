//! Touches by a machine whose position wanders.

use model_discrepancy::{LinearModel, Options, close_loop};
use nalgebra::{DMatrix, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::linear_model::{effect, normal, push, scalars};

const TOUCHES: usize = 48;
const TRIALS: u64 = 100;
/// Correlation of the machine's position from touch to touch.
const PHI: f64 = 0.7;

/// Touches all over a sphere; the position wanders, and nothing drifts.
fn wandering(seed: u64) -> LinearModel {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut vector = || Vector3::from_fn(|_, _| normal(&mut rng));
    let normals: Vec<_> = (0..TOUCHES).map(|_| vector().normalize()).collect();
    let mut position = vector();
    let data: Vec<f64> = normals
        .iter()
        .map(|normal| {
            position = PHI * position + (1.0 - PHI * PHI).sqrt() * vector();
            normal.dot(&position)
        })
        .collect();
    let mut model = scalars(&data, &[]);
    let time = |i: usize| i as f64 / TOUCHES as f64 - 0.5;
    push(
        &mut model,
        effect("drift", 3),
        DMatrix::from_fn(TOUCHES, 3, |i, axis| time(i) * normals[i][axis]),
    );
    model.declared.directions = Some(normals);
    model
}

fn additions(of: impl Fn(u64) -> LinearModel) -> usize {
    let options = Options { nested: false, ..Options::default() };
    let adds = |seed: &u64| {
        let closure = close_loop(&of(*seed), &[], &options).expect("the model has no parameters");
        !closure.steps.is_empty()
    };
    (0..TRIALS).filter(adds).count()
}

#[test]
fn a_wandering_position_is_no_drift() {
    // Size 0.05 in 100 trials: mean 5, standard deviation 2.2, plus three of them.
    let with = additions(wandering);
    assert!(with <= 11, "{with}");
    // The touches look all ways, so the residual itself seems white.
    let without = additions(|seed| {
        let mut model = wandering(seed);
        model.declared.directions = None;
        model
    });
    assert!(without > 11, "{without}");
}
