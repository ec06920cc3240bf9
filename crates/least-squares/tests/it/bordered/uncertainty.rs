//! Leverages, and what one reading's error does to the estimate.

use least_squares::{BorderedOptions, BorderedProblem, bordered_covariance, solve_bordered};

use super::problems::{GAUGE, Ranging};

fn held() -> BorderedOptions {
    BorderedOptions { held_shared: GAUGE.to_vec(), ..BorderedOptions::default() }
}

#[test]
fn leverages_sum_to_the_number_of_parameters() {
    let (truth, problem, _) = Ranging::simulate(5, 9, 1e-3, 0.0, 5);
    let options = BorderedOptions { held_blocks: vec![4], ..held() };
    let covariance = bordered_covariance(&problem, &truth, &options).unwrap();
    let of_blocks: f64 = (0..9).map(|k| covariance.leverages(k).sum()).sum();
    let sum = of_blocks + covariance.shared_leverages().sum();
    let parameters = (20 - GAUGE.len() + 8 * 3) as f64;
    assert!((sum - parameters).abs() < 1e-9, "{sum} of {parameters}");
}

/// A leverage is how much of a reading's error its own residual does not show.
#[test]
fn leverages_predict_what_a_changed_reading_does() {
    // Sigma of the change: small enough for the model to be linear over it.
    const CHANGE: f64 = 1e-3;
    let (_, mut problem, start) = Ranging::simulate(6, 8, 1e-2, 0.1, 6);
    let before = solve_bordered(&problem, start, &held()).unwrap().point;
    let covariance = bordered_covariance(&problem, &before, &held()).unwrap();
    let (block, row) = (3, 2);
    let leverage = covariance.leverages(block)[row];
    let residual = |problem: &Ranging, at: &least_squares::BorderedPoint| {
        let mut rows = [0.0; 6];
        problem.residuals(block, &at.shared, &at.blocks[9..12], &mut rows);
        rows[row]
    };
    let first = residual(&problem, &before);
    problem.ranges[block * 6 + row] += CHANGE * problem.sigma;
    let after = solve_bordered(&problem, before, &held()).unwrap().point;
    let shown = (residual(&problem, &after) - first) / -CHANGE;
    // Steps end within 1e-6 of a sigma, over a change of 1e-3.
    assert!((shown - (1.0 - leverage)).abs() < 1e-3, "{shown} and {leverage}");
    assert!(leverage > 0.05 && leverage < 0.99, "{leverage} would show nothing");
}

/// Normalised squared error of the shared point over trials; its mean is the number of free
/// directions, its standard deviation √(2 n / trials), and the bound 4 of them.
#[test]
fn covariance_predicts_the_scatter() {
    const TRIALS: u64 = 150;
    let free: Vec<usize> = (0..20).filter(|i| !GAUGE.contains(i)).collect();
    let mut sum = 0.0;
    for seed in 0..TRIALS {
        let (truth, mut problem, start) = Ranging::simulate(5, 10, 1e-3, 0.01, 100 + seed);
        // The offsets are drawn from -1 to 1, not from a normal distribution: know little.
        problem.offset_sigma = 1e3;
        let fit = solve_bordered(&problem, start, &held()).unwrap();
        let covariance = bordered_covariance(&problem, &fit.point, &held()).unwrap().shared();
        let part = nalgebra::DMatrix::from_fn(free.len(), free.len(), |i, j| {
            covariance[(free[i], free[j])]
        });
        let error = nalgebra::DVector::from_fn(free.len(), |i, _| {
            fit.point.shared[free[i]] - truth.shared[free[i]]
        });
        sum += error.dot(&part.cholesky().unwrap().solve(&error));
    }
    let mean = sum / TRIALS as f64;
    let (expected, bound) = (14.0, 4.0 * (28.0 / TRIALS as f64).sqrt());
    assert!((mean - expected).abs() < bound, "{mean} for {expected}");
}
