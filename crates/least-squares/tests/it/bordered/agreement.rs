//! The bordered solver against the dense one.

use least_squares::{
    AsDense, BorderedOptions, Loss, Options, RobustRows, bordered_covariance, check_jacobian,
    solve, solve_bordered,
};

use super::problems::{GAUGE, Poses, Ranging};

/// Steps of both solvers end within some 1e-6 standard uncertainties of the minimum.
const AGREEMENT_SIGMAS: f64 = 1e-5;
/// Relative to the standard uncertainties: both go by orthogonal elimination, at a condition of
/// 1e4, at points 1e-5 standard uncertainties apart.
const COVARIANCE_AGREEMENT: f64 = 1e-7;

fn held() -> BorderedOptions {
    BorderedOptions { held_shared: GAUGE.to_vec(), ..BorderedOptions::default() }
}

#[test]
fn jacobians_of_the_test_problems_are_right() {
    let (_, ranging, start) = Ranging::simulate(4, 3, 1e-3, 1.0, 1);
    let check = check_jacobian(&AsDense(&ranging), &start);
    assert!(check.worst_relative_error() < 1e-8, "{check}");
    let (poses, start) = Poses::simulate(4, 3, 1e-2, 1);
    let check = check_jacobian(&AsDense(&poses), &start);
    assert!(check.worst_relative_error() < 1e-8, "{check}");
}

#[test]
fn estimate_and_covariance_are_those_of_the_dense_solver() {
    let (_, problem, start) = Ranging::simulate(6, 12, 1e-3, 1.0, 2);
    let dense_options = Options { held: GAUGE.to_vec(), ..Options::default() };
    let dense = solve(&AsDense(&problem), start.clone(), &dense_options).unwrap();
    let fit = solve_bordered(&problem, start, &held()).unwrap();
    let sigma = dense.standard_uncertainties();
    let numbers = dense.point.shared.iter().chain(&dense.point.blocks);
    let found = fit.point.shared.iter().chain(&fit.point.blocks);
    for (i, (expected, found)) in numbers.zip(found).enumerate() {
        let error = (expected - found).abs();
        assert!(error <= AGREEMENT_SIGMAS * sigma[i], "{i}: {error:e} of {:e}", sigma[i]);
    }
    assert_eq!(fit.degrees_of_freedom, dense.degrees_of_freedom);
    let factors = (fit.variance_factor.unwrap(), dense.variance_factor.unwrap());
    assert!((factors.0 / factors.1 - 1.0).abs() < 1e-9, "{factors:?}");
    compare_covariance(&problem, &fit.point, &held(), &dense.covariance);
}

#[test]
fn poses_of_a_body_agree_with_the_dense_solver() {
    let (problem, start) = Poses::simulate(5, 7, 1e-2, 3);
    let options = BorderedOptions { held_blocks: vec![0], ..BorderedOptions::default() };
    let dense_options = Options { held: (15..21).collect(), ..Options::default() };
    let dense = solve(&AsDense(&problem), start.clone(), &dense_options).unwrap();
    let fit = solve_bordered(&problem, start, &options).unwrap();
    for (k, (expected, found)) in dense.point.shared.iter().zip(&fit.point.shared).enumerate() {
        let sigma = dense.standard_uncertainties()[k];
        assert!((expected - found).abs() <= AGREEMENT_SIGMAS * sigma, "{expected} {found}");
    }
    assert_eq!(fit.degrees_of_freedom, dense.degrees_of_freedom);
    compare_covariance(&problem, &fit.point, &options, &dense.covariance);
}

#[test]
fn robust_fits_agree_with_the_dense_solver() {
    let (_, mut problem, start) = Ranging::simulate(6, 12, 1e-3, 0.1, 4);
    problem.ranges[17] += 0.5;
    let rows = 0..problem.ranges.len();
    let robust = |rows| vec![RobustRows { rows, block_rows: 1, loss: Loss::cauchy_95() }];
    let dense_options =
        Options { held: GAUGE.to_vec(), robust: robust(rows), ..Options::default() };
    let dense = solve(&AsDense(&problem), start.clone(), &dense_options).unwrap();
    let options = BorderedOptions { robust: robust(0..6), ..held() };
    let fit = solve_bordered(&problem, start, &options).unwrap();
    let sigma = dense.standard_uncertainties();
    for (i, (expected, found)) in dense.point.shared.iter().zip(&fit.point.shared).enumerate() {
        // Reweighting converges linearly, so that the last step leaves more.
        let error = (expected - found).abs();
        assert!(error <= 1e-3 * sigma[i], "{i}: {error:e} of {:e}", sigma[i]);
    }
    assert!((fit.report.final_cost / dense.report.final_cost - 1.0).abs() < 1e-9);
}

fn compare_covariance<P: least_squares::BorderedProblem>(
    problem: &P,
    at: &least_squares::BorderedPoint,
    options: &BorderedOptions,
    dense: &nalgebra::DMatrix<f64>,
) {
    let covariance = bordered_covariance(problem, at, options).unwrap();
    let (n, b) = (problem.shared_dim(), problem.block_dim());
    let agree = |part: nalgebra::DMatrix<f64>, row: usize, column: usize| {
        for i in 0..part.nrows() {
            for j in 0..part.ncols() {
                let (a, b) = (row + i, column + j);
                let scale = (dense[(a, a)] * dense[(b, b)]).sqrt();
                let error = (part[(i, j)] - dense[(a, b)]).abs();
                assert!(error <= COVARIANCE_AGREEMENT * scale, "{a} {b}: {error:e} of {scale:e}");
            }
        }
    };
    agree(covariance.shared(), 0, 0);
    for k in 0..problem.block_count() {
        agree(covariance.block(k), n + k * b, n + k * b);
        agree(covariance.cross(k), n + k * b, 0);
        agree(covariance.between(k, 1), n + k * b, n + b);
    }
}
