use least_squares::{Options, Problem, SolveError, check_jacobian, covariance, solve};
use nalgebra::{DMatrix, DVector};

struct Line;

impl Problem for Line {
    type Point = DVector<f64>;
    fn residual_count(&self) -> usize {
        4
    }
    fn tangent_dim(&self) -> usize {
        2
    }
    fn residuals(&self, at: &DVector<f64>, out: &mut DVector<f64>) {
        for (i, x) in [0.0_f64, 1.0, 2.0, 3.0].into_iter().enumerate() {
            out[i] = at[0] + at[1] * x - (1.0 + 2.0 * x + 0.1 * (x * 7.0).sin());
        }
    }
    fn jacobian(&self, _: &DVector<f64>, out: &mut DMatrix<f64>) {
        for (i, x) in [0.0_f64, 1.0, 2.0, 3.0].into_iter().enumerate() {
            out[(i, 0)] = 1.0;
            out[(i, 1)] = x;
        }
    }
    fn retract(&self, at: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        at + step
    }
}

#[test]
fn line() {
    let s = solve(&Line, DVector::from_vec(vec![100.0, -3.0]), &Options::default()).unwrap();
    println!("{} {} {}", s.point, s.covariance, s.report);
    let c = covariance(&Line, &s.point, &Options::default()).unwrap();
    assert!((c.matrix - s.covariance).norm() < 1e-15);
    let check = check_jacobian(&Line, &s.point);
    assert!(check.worst_relative_error() < 1e-9, "{check}");
    let held = Options { held: vec![7], ..Options::default() };
    assert_eq!(
        solve(&Line, DVector::from_vec(vec![0.0, 0.0]), &held).unwrap_err(),
        SolveError::DirectionOutOfRange { index: 7, tangent_dim: 2 }
    );
}
