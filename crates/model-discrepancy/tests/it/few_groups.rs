//! Few groups of many readings each, and a model of more parameters than groups could tell, as the steps of a
//! survey: declared noise tells what so few groups could not.

use model_discrepancy::{Closure, Group, Options, Role, close_loop};
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::linear_model::{effect, normal, push, scalars, set_base};

/// Readings of a group.
const PER_GROUP: usize = 24;
/// Parameters, more than three readings of each of eight groups determine.
const PARAMETERS: usize = 30;
/// Size of the effect over its standard uncertainty.
const LARGE: f64 = 20.0;
const TRIALS: u64 = 60;
/// Of 60 at the loop's level of one in a hundred, four come once in three hundred.
const MOST_FALSE: usize = 3;

fn closed(seed: u64, groups: usize, size: f64, phi: f64, nested: bool) -> Closure {
    let n = groups * PER_GROUP;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let shape: Vec<f64> = (0..n).map(|_| normal(&mut rng)).collect();
    let norm = shape.iter().map(|v| v * v).sum::<f64>().sqrt();
    let mut memory = normal(&mut rng);
    let mut data = Vec::with_capacity(n);
    for (i, column) in shape.iter().enumerate() {
        let fresh = normal(&mut rng);
        memory = if i % PER_GROUP == 0 {
            fresh
        } else {
            phi * memory + (1.0 - phi * phi).sqrt() * fresh
        };
        data.push(memory + size * column / norm);
    }
    let mut model = scalars(&data, &[]);
    let layout = &mut model.declared.layout;
    layout.sigma_declared = true;
    layout.groups = (0..groups).map(|g| Group { name: g.to_string(), role: Role::Fit }).collect();
    layout.observations = (0..n).map(|i| i / PER_GROUP).collect();
    let names: Vec<String> = (0..PARAMETERS).map(|k| format!("p{k}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    set_base(&mut model, &names, DMatrix::from_fn(n, PARAMETERS, |_, _| normal(&mut rng)));
    push(&mut model, effect("shape", 1), DMatrix::from_column_slice(n, 1, &shape));
    let options = Options { nested, ..Options::default() };
    close_loop(&model, &[], &options).expect("a sound model")
}

#[test]
fn declared_noise_names_with_few_groups_what_is_large() {
    for groups in [4, 5, 7] {
        let closure = closed(1, groups, LARGE, 0.0, false);
        let names: Vec<&str> = closure.steps.iter().map(|step| step.effect.as_str()).collect();
        assert_eq!(names, ["shape"], "{groups} groups");
    }
}

/// Eight groups are judged as they stand, and the choice is repeated with seven.
#[test]
fn what_eight_groups_show_seven_find_again() {
    let closure = closed(2, 8, LARGE, 0.0, true);
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.remaining);
    assert_eq!(closure.steps[0].stability.resampled, Some(1.0));
}

#[test]
fn few_groups_of_white_noise_or_of_noise_with_memory_add_nothing() {
    for (groups, phi) in [(4, 0.0), (5, 0.7), (7, 0.7)] {
        let is_false = |seed: &u64| !closed(100 + seed, groups, 0.0, phi, false).steps.is_empty();
        let added = (0..TRIALS).filter(is_false).count();
        assert!(added <= MOST_FALSE, "{added} of {TRIALS}: {groups} groups, memory {phi}");
    }
}
