//! What a plan is foreseen to tell apart is what measurements tell.

use model_discrepancy::{Foreseen, LinearModel, Options, close_loop};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::linear_model::{normal, scalars};

/// Noise of a reading, mm.
const SIGMA_MM: f64 = 0.01;
/// What one unit of place adds, mm: ten times the noise at the places that were measured.
const SLOPE: f64 = 0.1;
/// Readings that were taken, and that are planned.
const MEASURED: usize = 24;
const PLANNED: usize = 12;
/// Share of the loops that may miss.
const MISSED: f64 = 0.025;

/// Places on either side of zero.
fn either_side(n: usize, far: f64) -> impl Iterator<Item = f64> {
    (0..n).map(move |i| if i % 2 == 0 { far } else { -far })
}

/// A line measured where a cube is the same, and planned readings elsewhere, of which the model has
/// `planned`.
fn model(far: f64, seed: u64, planned: impl Fn(f64, f64) -> f64) -> LinearModel {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = || SIGMA_MM * normal(&mut rng);
    let mut data: Vec<f64> = either_side(MEASURED, 1.0).map(|x| SLOPE * x + noise()).collect();
    data.extend(either_side(PLANNED, far).map(|x| planned(x, noise())));
    let x: Vec<f64> = either_side(MEASURED, 1.0).chain(either_side(PLANNED, far)).collect();
    let power = |n| x.iter().map(|x: &f64| x.powi(n)).collect();
    scalars(&data, &[("line", power(1)), ("cube", power(3)), ("square", power(2))])
}

/// How often the truth is told from each rival.
fn foreseen(far: f64, truth: &str, rivals: &[&str]) -> Option<Vec<f64>> {
    let options = Options { nested: false, ..Options::default() };
    let planned: Vec<usize> = (MEASURED..MEASURED + PLANNED).collect();
    // What stands in planned rows is of no account.
    let model = model(far, 1, |x, _| 1e3 * x);
    let foreseen =
        Foreseen { model: &model, covariates: &[], options: &options, planned: &planned };
    foreseen.told_apart(&[truth], (truth, rivals), MISSED).expect("measured rows can be fitted")
}

#[test]
fn what_looks_alike_where_it_is_planned_is_not_told_apart() {
    assert_eq!(foreseen(1.0, "line", &["cube", "square"]), Some(vec![0.0, 1.0]));
}

#[test]
fn what_differs_by_several_times_the_noise_is_told_apart_either_way() {
    for (truth, rival) in [("line", "cube"), ("cube", "line")] {
        let share = foreseen(0.5, truth, &[rival]).expect("both are in the model");
        assert!(share[0] >= 1.0 - MISSED, "{truth}: {share:?}");
    }
}

#[test]
fn what_is_not_in_the_model_is_not_foreseen() {
    assert_eq!(foreseen(0.5, "parabola", &["line"]), None);
}

/// Readings of the planned places: at 0.97 line and cube differ by 0.6 of the noise, and hardly any
/// loop tells them apart; at 0.9 by 1.7 times, and most do.
#[test]
fn the_share_is_that_of_loops_on_measured_readings() {
    const SEEDS: u64 = 40;
    /// Three standard deviations of the difference of two shares of forty, at one half.
    const SPREAD: f64 = 3.0 * 0.112;
    let options = Options { nested: false, ..Options::default() };
    for far in [0.97, 0.9] {
        let told = (0..SEEDS).filter(|seed| {
            let measured = model(far, 100 + seed, |x, noise| SLOPE * x + noise);
            let closure = close_loop(&measured, &[], &options).expect("all can be fitted");
            closure.steps.iter().any(|s| s.effect == "line" && s.indistinguishable_from.is_empty())
        });
        let told = told.count() as f64 / SEEDS as f64;
        let share = foreseen(far, "line", &["cube"]).expect("both are in the model")[0];
        assert!((share - told).abs() <= SPREAD, "{far}: {share}, measured {told}");
    }
}
