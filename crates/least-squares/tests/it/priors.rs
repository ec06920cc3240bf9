//! Prior knowledge as rows.

use least_squares::{
    Options, Prior, Problem, SolveError, WithPrior, check_jacobian, solve, with_vector_prior,
};
use nalgebra::{DMatrix, DVector};

use crate::problems::{Written, line};
use crate::suites::dual::Dual;

/// Round-off of a fit with values of 10 and a condition number of 10.
const EXACT_TOL: f64 = 1e-11;

const POINTS: [(f64, f64); 4] = [(0.0, 1.1), (1.0, 2.9), (2.0, 5.2), (3.0, 6.8)];

fn start() -> DVector<f64> {
    DVector::zeros(2)
}

#[test]
fn an_independent_prior_is_an_extra_row() {
    let problem = line(&POINTS);
    let prior = Prior::independent(&[(1.5, 0.25)]);
    let with =
        solve(&with_vector_prior(&problem, &[1], prior).unwrap(), start(), &Options::default())
            .unwrap();
    let rows = Written::new(&["offset", "slope"], 5, |p: &[Dual]| {
        let mut rows: Vec<Dual> = POINTS.iter().map(|(x, y)| p[0] + p[1] * *x - *y).collect();
        rows.push((p[1] - 1.5) / 0.25);
        rows
    });
    let extra = solve(&rows, start(), &Options::default()).unwrap();
    assert!((&with.point - &extra.point).amax() < EXACT_TOL);
    assert!((&with.covariance - &extra.covariance).amax() < EXACT_TOL);
    assert_eq!(with.degrees_of_freedom, 3);
}

/// Expected values from the normal equations `(JᵀJ + C⁻¹)⁻¹ (Jᵀ y + C⁻¹ m)`, well conditioned here.
#[test]
fn a_correlated_prior_combines_by_information() {
    let problem = line(&POINTS);
    let mean = DVector::from_vec(vec![0.5, 2.5]);
    let covariance = DMatrix::from_row_slice(2, 2, &[0.04, -0.03, -0.03, 0.09]);
    let prior = Prior { mean: mean.clone(), covariance: covariance.clone() };
    let with = with_vector_prior(&problem, &[0, 1], prior).unwrap();
    let fit = solve(&with, start(), &Options::default()).unwrap();

    let design = DMatrix::from_fn(4, 2, |i, j| if j == 0 { 1.0 } else { POINTS[i].0 });
    let data = DVector::from_fn(4, |i, _| POINTS[i].1);
    let information = covariance.try_inverse().unwrap();
    let combined = (design.transpose() * &design + &information).try_inverse().unwrap();
    let expected = &combined * (design.transpose() * data + &information * mean);
    assert!((&fit.point - expected).amax() < EXACT_TOL);
    assert!((&fit.covariance - combined).amax() < EXACT_TOL);
}

/// The distance from the origin as a quantity of the point: a row that is not linear.
#[test]
fn a_prior_on_any_function_of_the_point_has_a_right_jacobian() {
    let problem = line(&POINTS);
    let prior = Prior::independent(&[(3.0, 0.1)]);
    let quantity = |p: &DVector<f64>| {
        let norm = p.norm();
        (DVector::from_element(1, norm), DMatrix::from_row_slice(1, 2, (p / norm).as_slice()))
    };
    let with = WithPrior::new(&problem, prior, quantity).unwrap();
    let at = DVector::from_vec(vec![0.7, 1.9]);
    let check = check_jacobian(&with, &at);
    assert!(check.worst_relative_error() < 1e-9, "{check}");
    assert_eq!(with.parameter_name(1), "slope");
}

#[test]
fn a_prior_makes_a_free_direction_observable() {
    let single = [(2.0, 5.0)];
    let problem = line(&single);
    let free = solve(&problem, start(), &Options::default()).unwrap_err();
    assert!(matches!(free, SolveError::Unobservable { .. }), "{free}");
    let prior = Prior::independent(&[(1.0, 0.5)]);
    let with = with_vector_prior(&problem, &[0], prior).unwrap();
    let fit = solve(&with, start(), &Options::default()).unwrap();
    assert!((&fit.point - DVector::from_vec(vec![1.0, 2.0])).amax() < EXACT_TOL);
    // Of the slope: the datum's 1 and the prior's 0.5 over a lever of 2.
    assert!((fit.standard_uncertainties()[1] - 1.25_f64.sqrt() / 2.0).abs() < EXACT_TOL);
    assert_eq!(fit.variance_factor, None);
}

#[test]
fn bad_priors_are_refused() {
    let problem = line(&POINTS);
    let refuse = |mean_and_sigma: &[(f64, f64)]| {
        let prior = Prior::independent(mean_and_sigma);
        with_vector_prior(&problem, &[0, 1], prior).err().unwrap()
    };
    for sigma in [0.0, f64::NAN, f64::INFINITY] {
        let error = refuse(&[(0.0, 1.0), (0.0, sigma)]);
        assert!(matches!(error, SolveError::InvalidPrior { row: 1, .. }), "{error}");
    }
    assert!(matches!(
        refuse(&[(0.0, 1.0), (f64::NAN, 1.0)]),
        SolveError::InvalidPrior { row: 1, .. }
    ));
    assert!(matches!(refuse(&[(0.0, 1.0)]), SolveError::InvalidPrior { .. }));

    let mean = DVector::zeros(2);
    let covariance = DMatrix::from_element(2, 2, 1.0);
    let singular = with_vector_prior(&problem, &[0, 1], Prior { mean, covariance });
    assert_eq!(singular.err().unwrap(), SolveError::InvalidPrior { row: 1, variance: 0.0 });
    let absent = with_vector_prior(&problem, &[2], Prior::independent(&[(0.0, 1.0)]));
    assert_eq!(absent.err().unwrap(), SolveError::DirectionOutOfRange { index: 2, tangent_dim: 2 });
}
