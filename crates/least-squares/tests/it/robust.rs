//! Robust losses, per residual and per block.

use least_squares::{Loss, Options, RobustRows, solve};
use nalgebra::{DVector, Matrix2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use crate::problems::{Written, line};
use crate::suites::dual::Dual;

const LOSSES: [Loss; 4] = [
    Loss::Huber { scale: 1.3 },
    Loss::Cauchy { scale: 1.3 },
    Loss::Tukey { scale: 1.3 },
    Loss::GemanMcClure { scale: 1.3 },
];

fn robust(block_rows: usize, loss: Loss) -> Options {
    Options { robust: vec![RobustRows::all(block_rows, loss)], ..Options::default() }
}

/// A line of slope 2 and offset 1 with small errors, and one gross error at the end.
fn points_with_outlier() -> Vec<(f64, f64)> {
    let mut points: Vec<_> =
        (0..20).map(f64::from).map(|x| (x, 1.0 + 2.0 * x + 0.3 * (7.0 * x).sin())).collect();
    points.push((20.0, 141.0));
    points
}

#[test]
fn weights_are_the_derivative_of_the_loss() {
    // Second-order truncation at 1e-5 of the argument and rounding at 1e-11.
    const DIFFERENCE_TOL: f64 = 1e-9;
    for loss in LOSSES {
        assert_eq!(loss.evaluate(0.0), (0.0, 1.0));
        for s in [1e-3, 0.1, 1.0, 1.5, 1.8, 5.0, 1e3] {
            let h = 1e-5 * s;
            let slope = (loss.evaluate(s + h).0 - loss.evaluate(s - h).0) / (2.0 * h);
            let weight = loss.evaluate(s).1;
            assert!((slope - weight).abs() < DIFFERENCE_TOL, "{loss:?} at {s}: {slope} {weight}");
        }
    }
}

#[test]
fn the_solution_is_stationary_in_the_robust_cost() {
    let points = points_with_outlier();
    for loss in LOSSES {
        let problem = line(&points);
        let truth = DVector::from_vec(vec![1.0, 2.0]);
        let fit = solve(&problem, truth, &robust(1, loss)).unwrap();
        let cost = |p: &DVector<f64>| -> f64 {
            points.iter().map(|(x, y)| loss.evaluate((p[0] + p[1] * x - y).powi(2)).0).sum()
        };
        // Central differences of a cost of 100 over steps of 1e-5: rounding 1e-9, kinks none.
        for i in 0..2 {
            let mut step = DVector::zeros(2);
            step[i] = 1e-5;
            let slope = (cost(&(&fit.point + &step)) - cost(&(&fit.point - &step))) / 2e-5;
            assert!(slope.abs() < 1e-6, "{loss:?}: slope {slope}");
        }
        assert!((fit.report.final_cost - 0.5 * cost(&fit.point)).abs() < 1e-9);
    }
}

#[test]
fn an_outlier_pulls_less_the_harder_the_loss() {
    let points = points_with_outlier();
    let truth = DVector::from_vec(vec![1.0, 2.0]);
    let slope_error = |options: &Options| {
        (solve(&line(&points), truth.clone(), options).unwrap().point[1] - 2.0).abs()
    };
    let plain = slope_error(&Options::default());
    let huber = slope_error(&robust(1, LOSSES[0]));
    let cauchy = slope_error(&robust(1, LOSSES[1]));
    assert!(huber < 0.1 * plain && cauchy < 0.5 * huber, "{plain} {huber} {cauchy}");
}

#[test]
fn a_rejected_outlier_leaves_no_trace() {
    let points = points_with_outlier();
    let start = DVector::from_vec(vec![1.0, 2.0]);
    let fit = solve(&line(&points), start.clone(), &robust(1, Loss::Tukey { scale: 4.685 }));
    let fit = fit.unwrap();
    let clean =
        solve(&line(&points[..20]), start, &robust(1, Loss::Tukey { scale: 4.685 })).unwrap();
    assert!((&fit.point - &clean.point).amax() < 1e-9);
    assert!((&fit.covariance - &clean.covariance).amax() < 1e-9);
    assert_eq!(fit.weights[20], 0.0);
    assert_eq!((fit.report.residuals_used, fit.report.residuals_given), (20, 21));
    assert_eq!(fit.degrees_of_freedom, 18);
}

#[test]
fn a_wide_loss_is_no_loss() {
    let points = points_with_outlier();
    let plain = solve(&line(&points), DVector::zeros(2), &Options::default()).unwrap();
    let wide = solve(&line(&points), DVector::zeros(2), &robust(1, Loss::Huber { scale: 1e6 }));
    assert_eq!(plain.point, wide.unwrap().point);
}

/// Blocks are judged by their norm, so turning the axes of every block changes nothing; judged
/// row by row, it does.
#[test]
fn a_block_is_weighted_as_one() {
    let data: Vec<Vector2<f64>> = (0..12)
        .map(f64::from)
        .map(|i| Vector2::new((3.0 * i).sin(), (5.0 * i).cos()))
        .chain([Vector2::new(30.0, -20.0)])
        .collect();
    let mean_in_axes = |angle: f64, options: &Options| {
        let (sin, cos) = angle.sin_cos();
        let turn = Matrix2::new(cos, -sin, sin, cos);
        let problem = Written::new(&["x", "y"], 2 * data.len(), |p: &[Dual]| {
            let row = |d: &Vector2<f64>, i: usize| {
                (p[0] - d[0]) * turn[(i, 0)] + (p[1] - d[1]) * turn[(i, 1)]
            };
            data.iter().flat_map(|d| [row(d, 0), row(d, 1)]).collect()
        });
        solve(&problem, DVector::zeros(2), options).unwrap()
    };
    let huber = Loss::Huber { scale: 1.5 };
    let (straight, turned) =
        (mean_in_axes(0.0, &robust(2, huber)), mean_in_axes(0.7, &robust(2, huber)));
    assert!((&straight.point - &turned.point).amax() < 1e-9);
    assert_eq!(straight.weights[24], straight.weights[25]);
    let (straight, turned) =
        (mean_in_axes(0.0, &robust(1, huber)), mean_in_axes(0.7, &robust(1, huber)));
    assert!((&straight.point - &turned.point).amax() > 1e-2);
}

#[test]
fn rows_outside_the_range_keep_their_full_weight() {
    let points = points_with_outlier();
    let robust = vec![RobustRows { rows: 0..5, block_rows: 1, loss: LOSSES[0] }];
    let options = Options { robust, ..Options::default() };
    let fit = solve(&line(&points), DVector::zeros(2), &options).unwrap();
    assert!(fit.weights.rows_range(5..).iter().all(|w| *w == 1.0));
    assert!(fit.weights.rows_range(..5).iter().any(|w| *w < 1.0));
}

/// Ranges of a metre that are good to a micrometre, one of them half a millimetre off: rounding
/// of the ranges, not of the sum, is what hides the last decrease of the cost.
#[test]
fn long_ranges_with_short_uncertainties_converge() {
    const SIGMA_MM: f64 = 1e-3;
    let stations = [[0.0, 0.0, 0.0], [800.0, 0.0, 0.0], [100.0, 700.0, 0.0], [700.0, 600.0, 500.0]];
    for seed in 0..200 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let noise = Normal::new(0.0, SIGMA_MM).unwrap();
        let truth = [0; 3].map(|_| rng.random_range(100.0..900.0));
        let mut ranges = Vec::new();
        for k in 0..40 {
            let offsets: Vec<f64> = (0..3).map(|c| truth[c] - stations[k % 4][c]).collect();
            let range = DVector::from_vec(offsets).norm() - 0.3;
            ranges.push(range + noise.sample(&mut rng));
        }
        ranges[17] += 0.5;
        let problem = Written::new(&["x", "y", "z", "offset"], 40, |x: &[Dual]| {
            let range = |k: usize| {
                let square = |c: usize| (x[c] - stations[k % 4][c]) * (x[c] - stations[k % 4][c]);
                (square(0) + square(1) + square(2)).sqrt() - x[3]
            };
            (0..40).map(|k| (range(k) - ranges[k]) / SIGMA_MM).collect()
        });
        let robust = vec![RobustRows::all(1, Loss::cauchy_95())];
        let options = Options { robust, ..Options::default() };
        let start = DVector::from_fn(4, |i, _| if i < 3 { truth[i] + 0.1 } else { 0.0 });
        if let Err(refused) = solve(&problem, start, &options) {
            panic!("seed {seed}: {refused}");
        }
    }
}
