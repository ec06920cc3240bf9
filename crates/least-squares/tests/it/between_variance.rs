//! The scatter that observations share beyond what is known of each.

use least_squares::between_variance;
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const SETS: usize = 200;

/// Readings of one length, half of them known to 1 and half to 0.2, that share a scatter.
fn found(readings: usize, scatter: f64, seed: u64) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let known = |i: usize| if i.is_multiple_of(2) { 1.0 } else { 0.2 };
    let sigma: Vec<_> = (0..readings).map(known).collect();
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let data = sigma.iter().map(|s| s * normal() + scatter * normal());
    let data = DVector::from_iterator(readings, data);
    let residual = data.add_scalar(-data.mean());
    between_variance(&sigma, |_| true, &residual, &DMatrix::from_element(readings, 1, 1.0))
}

/// Mean of the scatter found, and its standard error.
fn mean(readings: usize, scatter: f64) -> (f64, f64) {
    let all: Vec<f64> = (0..SETS).map(|s| found(readings, scatter, s as u64).sqrt()).collect();
    let n = SETS as f64;
    let mean = all.iter().sum::<f64>() / n;
    let square = all.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (square / n).sqrt())
}

#[test]
fn many_readings_find_it() {
    let (mean, std) = mean(60, 0.7);
    // A median is a little more than the most likely value: by 1/n of it, 2 %.
    assert!((mean - 0.7).abs() < 4.0 * std + 0.014, "{mean} ± {std}");
}

#[test]
fn without_any_it_stays_below_what_is_known() {
    let (mean, _) = mean(60, 0.0);
    // The better half are known to 0.2: more than half of that would have shown in 30 of them.
    assert!(mean < 0.1, "{mean}");
}

#[test]
fn few_readings_never_call_it_zero() {
    let least = (0..SETS).map(|s| found(4, 0.7, s as u64)).fold(f64::INFINITY, f64::min);
    assert!(least > 0.0);
    assert!(found(1, 0.7, 1).abs() < f64::EPSILON, "one reading has no scatter");
}

#[test]
fn rows_that_do_not_share_it_are_weighed_by_their_own_sigma_alone() {
    // Two rows that agree and two far apart: only where the latter share, there is a scatter.
    let residual = DVector::from_vec(vec![0.1, -0.1, 5.0, -5.0]);
    let jacobian = DMatrix::from_element(4, 1, 1.0);
    let of = |from: usize| between_variance(&[0.1; 4], |row| row / 2 == from, &residual, &jacobian);
    assert!(of(1) > 10.0 * of(0));
}
