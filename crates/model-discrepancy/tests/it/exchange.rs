//! Effects that were added one by one, and others that describe the data better.

use std::f64::consts::PI;

use model_discrepancy::{Effect, Options, Verdict, close_loop};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::linear_model::{parameter, push, scalars};

/// Readings, one group each.
const READINGS: usize = 32;
/// Size of both missing effects over the noise.
const SIZE: f64 = 20.0;

/// Orthonormal, k-th of the discrete cosine transform.
fn wave(k: usize) -> Vec<f64> {
    let n = READINGS as f64;
    let angle = |i: usize| PI * (i as f64 + 0.5) * k as f64 / n;
    (0..READINGS).map(|i| (2.0 / n).sqrt() * angle(i).cos()).collect()
}

fn sum(terms: &[(f64, usize)]) -> Vec<f64> {
    let add = |mut sum: Vec<f64>, &(factor, k): &(f64, usize)| {
        sum.iter_mut().zip(wave(k)).for_each(|(s, w)| *s += factor * w);
        sum
    };
    terms.iter().fold(vec![0.0; READINGS], add)
}

/// Directions of the effects; the noise has all others.
const U: usize = 5;
const V: usize = 9;
const W: usize = 14;
const X: usize = 20;

/// Of u + v, `both` takes most, as it is u + v + 0.3 w, and `rest`, w + 0.5 x, all but 2.7 standard
/// deviations of what is left: too little for a third effect. «one» and «other», u and v, leave nothing.
#[test]
fn two_effects_take_the_place_of_a_wider_one_and_what_made_up_for_it() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut terms: Vec<_> = (1..READINGS)
        .filter(|k| ![U, V, W, X].contains(k))
        .map(|k| (if rng.random::<bool>() { 1.0 } else { -1.0 }, k))
        .collect();
    terms.extend([(SIZE, U), (SIZE, V)]);
    let effects = [
        ("both", sum(&[(1.0, U), (1.0, V), (0.3, W)])),
        ("rest", sum(&[(1.0, W), (0.5, X)])),
        ("one", wave(U)),
        ("other", wave(V)),
    ];
    let closure = close_loop(&scalars(&sum(&terms), &effects), &[], &Options::default()).unwrap();
    let mut names: Vec<_> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["one", "other"]);
    assert_eq!(closure.verdict, Verdict::Explained);
    for step in &closure.steps {
        let found = &step.parameters[0];
        // Orthonormal columns, and noise that is orthogonal to them: what is found is what is missing,
        // to round-off of sums of 32 terms of size 20.
        assert!((found.value - SIZE).abs() < 1e-9, "{} {}", step.effect, found.value);
        assert!(step.indistinguishable_from.is_empty(), "{:?}", step.indistinguishable_from);
    }
}

/// Two effects that would be one, but one of them is taken at a reading and the other at where that should
/// be: their difference is the residual, noise and all. They are no description of it, however few
/// amplitudes they have.
#[test]
fn two_effects_whose_difference_is_the_residual_take_no_place() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let named = [U, V, W, X];
    let large = 25;
    let mut terms: Vec<_> = (1..READINGS)
        .filter(|k| !named.contains(k) && *k != large)
        .map(|k| (if rng.random::<bool>() { 1.0 } else { -1.0 }, k))
        .collect();
    terms.extend(named.map(|k| (SIZE, k)));
    let residual = sum(&terms);
    // Seven times as large as the residual.
    let reading = sum(&[(300.0, large)]);
    let there = reading.iter().zip(&residual).map(|(a, b)| a + b).collect();
    let mut model = scalars(&residual, &[("reading", reading), ("there", there)]);
    let columns: Vec<_> = named.into_iter().flat_map(wave).collect();
    let parameters = ["u", "v", "w", "x"].map(parameter).into();
    let columns = DMatrix::from_vec(READINGS, named.len(), columns);
    push(&mut model, Effect::new("wide", "", parameters), columns);
    let closure = close_loop(&model, &[], &Options::default()).unwrap();
    let names: Vec<_> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
    assert_eq!(names, ["wide"]);
}

/// Beside «whole», «wide» takes most, as it is u + v + 0.3 x, and «made up», x + 0.3 y, most of what is wrong
/// with it: to «one» and «other», u and v, both have to go.
#[test]
fn two_of_three_are_replaced_at_once() {
    const Y: usize = 25;
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut terms: Vec<_> = (1..READINGS)
        .filter(|k| ![U, V, W, X, Y].contains(k))
        .map(|k| (if rng.random::<bool>() { 1.0 } else { -1.0 }, k))
        .collect();
    terms.extend([(SIZE, U), (SIZE, V), (2.0 * SIZE, W)]);
    let effects = [
        ("wide", sum(&[(1.0, U), (1.0, V), (0.3, X)])),
        ("made up", sum(&[(1.0, X), (0.3, Y)])),
        ("whole", wave(W)),
        ("one", wave(U)),
        ("other", wave(V)),
    ];
    let closure = close_loop(&scalars(&sum(&terms), &effects), &[], &Options::default()).unwrap();
    let mut names: Vec<_> = closure.steps.iter().map(|s| s.effect.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["one", "other", "whole"]);
    assert_eq!(closure.verdict, Verdict::Explained);
}
