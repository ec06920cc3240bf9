//! Hopeless and extreme input: an answer or a typed error, never a panic.

use least_squares::{
    Loss, Options, Problem, RobustRows, SolveError, Termination, check_jacobian, covariance, solve,
};
use nalgebra::{DMatrix, DVector};

use crate::problems::{Written, decay, decay_data, line};

fn vector(values: &[f64]) -> DVector<f64> {
    DVector::from_row_slice(values)
}

#[test]
fn exact_data_from_afar_and_from_the_solution_itself() {
    let data = decay_data(|_| 0.0);
    let problem = decay(&data);
    for start in [[1.0, 0.2, 0.0], [2.0, 0.7, 0.3], [2.0 + 1e-15, 0.7, 0.3 - 1e-16]] {
        let fit = solve(&problem, vector(&start), &Options::default()).unwrap();
        // Rounding of 12 sums of size 2, through a condition number of 10.
        assert!((&fit.point - vector(&[2.0, 0.7, 0.3])).amax() < 1e-13, "{}", fit.report);
    }
    let fit = solve(
        &line(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]),
        vector(&[0.0, 0.0]),
        &Options::default(),
    );
    let fit = fit.unwrap();
    assert_eq!(fit.report.termination, Some(Termination::Gradient));
    assert_eq!((fit.report.iterations, fit.variance_factor), (0, Some(0.0)));
}

#[test]
fn fewer_residuals_than_parameters_name_what_is_free() {
    let problem = line(&[(2.0, 5.0)]);
    let error = solve(&problem, vector(&[0.0, 0.0]), &Options::default()).unwrap_err();
    let SolveError::Unobservable { directions, best, report } = error else { panic!("{error}") };
    assert_eq!((directions.len(), report.rank, report.parameters), (1, 1, 2));
    assert!((best[0] + 2.0 * best[1] - 5.0).abs() < 1e-9);
    let none = line(&[]);
    let error = solve(&none, vector(&[1.0, 2.0]), &Options::default()).unwrap_err();
    let SolveError::Unobservable { directions, best, .. } = error else { panic!("{error}") };
    assert_eq!((directions.len(), *best), (2, vector(&[1.0, 2.0])));
}

#[test]
fn a_direction_nothing_depends_on_is_free() {
    let problem = Written::new(&["seen", "unseen"], 3, |p| {
        [1.0, 2.0, 4.0].map(|y| p[0] - y + p[1] * 0.0).to_vec()
    });
    let error = solve(&problem, vector(&[0.0, 7.0]), &Options::default()).unwrap_err();
    assert!(error.to_string().contains("free: 1.00·unseen;"), "{error}");
    let error = covariance(&problem, &vector(&[7.0 / 3.0, 7.0]), &Options::default());
    assert!(matches!(error, Err(SolveError::Unobservable { .. })));
    let held = Options { held: vec![1], ..Options::default() };
    let fit = solve(&problem, vector(&[0.0, 7.0]), &held).unwrap();
    assert!((fit.point[0] - 7.0 / 3.0).abs() < 1e-14);
}

#[test]
fn everything_held_returns_the_start() {
    let problem = line(&[(0.0, 1.0), (1.0, 2.0)]);
    let options = Options { held: vec![0, 1, 1], ..Options::default() };
    let fit = solve(&problem, vector(&[3.0, 4.0]), &options).unwrap();
    assert_eq!(fit.point, vector(&[3.0, 4.0]));
    assert_eq!(fit.covariance, DMatrix::zeros(2, 2));
    assert_eq!(fit.degrees_of_freedom, 2);
}

#[test]
fn a_start_of_the_wrong_length_is_an_error() {
    let problem = line(&[(0.0, 1.0), (1.0, 2.0), (2.0, 3.0)]);
    for start in [vector(&[]), vector(&[0.0]), vector(&[0.0, 0.0, 0.0])] {
        let error = solve(&problem, start, &Options::default()).unwrap_err();
        assert!(matches!(error, SolveError::InvalidStart), "{error}");
    }
    for at in [vector(&[]), vector(&[0.0]), vector(&[0.0, 0.0, 0.0])] {
        assert!(check_jacobian(&problem, &at).worst_relative_error().is_infinite());
    }
}

#[test]
fn what_cannot_be_evaluated_at_the_start_is_named() {
    let start = vector(&[0.0, 0.0]);
    for (value, reported) in [(f64::NAN, 1), (f64::INFINITY, 1), (1e300, 1)] {
        let error = solve(&line(&[(0.0, 1.0), (1.0, value)]), start.clone(), &Options::default());
        let Err(SolveError::NonFiniteResidual { row, .. }) = error else { panic!("{error:?}") };
        assert_eq!(row, reported);
    }
    let root = Written::new(&["x"], 2, |p| vec![p[0] - 1.0, p[0].sqrt()]);
    let error = solve(&root, vector(&[0.0]), &Options::default()).unwrap_err();
    assert!(matches!(error, SolveError::NonFiniteJacobian { row: 1, column: 0, .. }), "{error}");
}

#[test]
fn large_numbers_short_of_overflow_are_numbers() {
    let problem = line(&[(0.0, 1e150), (1.0, 3e150), (2.0, 4e150)]);
    let fit = solve(&problem, vector(&[0.0, 0.0]), &Options::default()).unwrap();
    // The gradient tolerance of 1e-12 times a residual that is a tenth of the slope.
    assert!((fit.point[1] / 1.5e150 - 1.0).abs() < 1e-12, "{} {}", fit.point, fit.report);
}

/// The logarithm ends at zero: full steps from the far side land where it is NaN.
#[test]
fn steps_that_leave_the_domain_are_shortened() {
    let problem = Written::new(&["x", "y"], 3, |p| {
        let log = |v: crate::suites::dual::Dual| {
            let derivative = v.value.recip();
            let mut out = v * derivative;
            out.value = v.value.ln();
            out
        };
        vec![log(p[0]) + 3.0, p[1] - 1.0, log(p[0] * p[1]) + 3.0]
    });
    let fit = solve(&problem, vector(&[50.0, 3.0]), &Options::default()).unwrap();
    assert!((fit.point[0] - (-3.0_f64).exp()).abs() < 1e-13);
}

#[test]
fn no_iterations_allowed_is_not_converged() {
    let data = decay_data(|t| 0.01 * t.sin());
    for (max_iterations, retry) in [(0, false), (0, true), (2, true)] {
        let options = Options { max_iterations, retry, ..Options::default() };
        let start = vector(&[1.0, 0.2, 0.0]);
        let error = solve(&decay(&data), start.clone(), &options).unwrap_err();
        let SolveError::NotConverged { best, report } = error else { panic!("{error}") };
        assert_eq!(*best == start, max_iterations == 0);
        assert!(report.iterations <= 2 * max_iterations && report.termination.is_none());
    }
}

#[test]
fn no_option_value_panics() {
    let data = decay_data(|t| 0.01 * t.sin());
    let nonsense = [f64::NAN, -1.0, 0.0, f64::INFINITY, f64::NEG_INFINITY, 1e300, 5e-324];
    let plain = solve(&decay(&data), vector(&[1.0, 0.2, 0.0]), &Options::default()).unwrap();
    for value in nonsense {
        for field in 0..5 {
            let mut options = Options::default();
            let fields = [
                &mut options.gradient_tolerance,
                &mut options.step_tolerance,
                &mut options.cost_tolerance,
                &mut options.initial_damping,
                &mut options.rank_tolerance,
            ];
            *fields.into_iter().nth(field).unwrap() = value;
            let result = solve(&decay(&data), vector(&[1.0, 0.2, 0.0]), &options);
            // A tolerance without effect leaves the others; the answer is the same.
            if value.is_nan() || value < 0.0 {
                let fit = result.unwrap();
                assert!((&fit.point - &plain.point).amax() < 1e-9, "{value} in {field}");
            }
        }
    }
}

#[test]
fn options_that_contradict_the_problem_are_refused() {
    let problem = line(&[(0.0, 1.0), (1.0, 2.0), (2.0, 2.5)]);
    let held = Options { held: vec![7], ..Options::default() };
    let error = solve(&problem, vector(&[0.0, 0.0]), &held).unwrap_err();
    assert_eq!(error, SolveError::DirectionOutOfRange { index: 7, tangent_dim: 2 });
    for (scale, block_rows) in [(0.0, 1), (-1.0, 1), (f64::NAN, 1), (1.0, 0)] {
        let robust = vec![RobustRows::all(block_rows, Loss::Cauchy { scale })];
        let options = Options { robust, ..Options::default() };
        let error = solve(&problem, vector(&[0.0, 0.0]), &options).unwrap_err();
        assert!(matches!(error, SolveError::InvalidLoss { index: 0, .. }), "{error}");
    }
}

/// A derivative that fails on the way, at points whose residuals are fine.
struct BlindBeyondOne;

impl Problem for BlindBeyondOne {
    type Point = DVector<f64>;

    fn residual_count(&self) -> usize {
        2
    }

    fn tangent_dim(&self) -> usize {
        1
    }

    fn residuals(&self, at: &DVector<f64>, out: &mut DVector<f64>) {
        out.copy_from(&vector(&[at[0] - 1.9, at[0] - 2.1]));
    }

    fn jacobian(&self, at: &DVector<f64>, out: &mut DMatrix<f64>) {
        out[(0, 0)] = 1.0;
        out[(1, 0)] = if at[0] > 1.0 { f64::NAN } else { 1.0 };
    }

    fn retract(&self, at: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        at + step
    }
}

#[test]
fn a_derivative_that_fails_on_the_way_is_named() {
    let error = solve(&BlindBeyondOne, vector(&[0.0]), &Options::default()).unwrap_err();
    assert!(matches!(error, SolveError::NonFiniteJacobian { row: 1, column: 0, .. }), "{error}");
}

/// A slope with the wrong sign: every step goes uphill.
struct Backwards;

impl Problem for Backwards {
    type Point = DVector<f64>;

    fn residual_count(&self) -> usize {
        3
    }

    fn tangent_dim(&self) -> usize {
        1
    }

    fn residuals(&self, at: &DVector<f64>, out: &mut DVector<f64>) {
        out.copy_from(&vector(&[at[0] - 1.0, at[0] - 2.0, at[0] - 4.0]));
    }

    fn jacobian(&self, _: &DVector<f64>, out: &mut DMatrix<f64>) {
        out.fill(-1.0);
    }

    fn retract(&self, at: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        at + step
    }
}

#[test]
fn a_wrong_jacobian_stalls_instead_of_converging() {
    let error = solve(&Backwards, vector(&[0.0]), &Options::default()).unwrap_err();
    assert!(matches!(error, SolveError::Stalled { .. }), "{error}");
    assert!(error.to_string().contains("check_jacobian"), "{error}");
}

/// A Jacobian that promises a change where there is none.
#[test]
fn residuals_that_never_move_stall() {
    let problem = Written::new(&["x"], 2, |p| {
        let mut stuck = p[0];
        stuck.value = 5.0;
        vec![stuck, stuck]
    });
    let error = solve(&problem, vector(&[0.0]), &Options::default()).unwrap_err();
    assert!(matches!(error, SolveError::Stalled { .. }), "{error}");
}

/// Readings far from the origin: rounding of a coordinate is 1e-10 of a standard uncertainty.
struct FarReadings {
    data: Vec<[f64; 2]>,
}

/// Distance from the origin in standard uncertainties of a reading.
const FAR: f64 = 5e5;

impl Problem for FarReadings {
    type Point = DVector<f64>;

    fn residual_count(&self) -> usize {
        self.data.len()
    }

    fn tangent_dim(&self) -> usize {
        2
    }

    fn residuals(&self, at: &DVector<f64>, out: &mut DVector<f64>) {
        for (out, [t, reading]) in out.iter_mut().zip(&self.data) {
            *out = (FAR + at[0] + at[1] * t) - (FAR + reading);
        }
    }

    fn jacobian(&self, _: &DVector<f64>, out: &mut DMatrix<f64>) {
        for (row, [t, _]) in self.data.iter().enumerate() {
            (out[(row, 0)], out[(row, 1)]) = (1.0, *t);
        }
    }

    fn retract(&self, at: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        at + step
    }
}

/// From every start that is a millionth of a standard uncertainty off, on the scale where rounding
/// decides which of two costs is the lower one.
#[test]
fn rounding_of_the_residuals_is_no_stall() {
    for seed in 0..2000_u32 {
        // Waves without order, some five standard uncertainties high.
        let reading = |i: u32| 7.0 * (f64::from(i) * 2.4 + f64::from(seed)).sin();
        let data = (0..46).map(|i| [f64::from(i) / 23.0 - 1.0, reading(i)]).collect();
        let problem = FarReadings { data };
        let found = solve(&problem, vector(&[0.0, 0.0]), &Options::default()).unwrap();
        let off = 1e-6 * f64::from(seed).cos();
        let near = vector(&[found.point[0] + off, found.point[1] - off]);
        let again = solve(&problem, near, &Options::default());
        assert!(again.is_ok(), "seed {seed}: {}", again.unwrap_err());
    }
}

/// Sigma over six decades and an origin 1e5 away: one answer, to rounding of the coordinates.
#[test]
fn sigma_and_origin_may_be_anything() {
    for sigma in [1e-6, 1e-3, 1.0] {
        for origin in [0.0, 1e5, -1e7] {
            let problem = Written::new(&["x", "y"], 6, |p| {
                (0..3)
                    .map(|i| 2.0 * f64::from(i))
                    .flat_map(|angle| {
                        let (sin, cos) = angle.sin_cos();
                        let target = [origin + cos + 1e-3, origin + sin - 2e-3];
                        [(p[0] + cos - target[0]) / sigma, (p[1] + sin - target[1]) / sigma]
                    })
                    .collect()
            });
            let fit = solve(&problem, vector(&[0.0, 0.0]), &Options::default()).unwrap();
            let expected = vector(&[origin + 1e-3, origin - 2e-3]);
            // Of the target (twice), the prediction and the point: half an ulp of 2 eps each.
            let rounding = 8.0 * f64::EPSILON * (1.0 + f64::abs(origin));
            let error = (&fit.point - expected).amax();
            assert!(error <= rounding, "{sigma} {origin}: {error}");
            let standard = sigma / 3_f64.sqrt();
            assert!((fit.standard_uncertainties()[0] / standard - 1.0).abs() < 1e-12);
        }
    }
}
