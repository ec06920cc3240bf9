//! The Jacobian checker: passes what is right, finds what is wrong.

use least_squares::{Problem, check_jacobian};
use nalgebra::{DMatrix, DVector};

use crate::problems::{Written, decay, decay_data};
use crate::suites::nist;

/// What extrapolated differences reach on smooth residuals, with a digit to spare.
const AGREEMENT: f64 = 1e-8;

#[test]
fn right_jacobians_pass_at_the_certified_points() {
    for (name, model) in nist::MODELS {
        let problem = nist::Nist::read(name, model);
        let check = check_jacobian(&problem, &problem.certified);
        assert!(check.worst_relative_error() < AGREEMENT, "{name}: {check}");
    }
}

/// A problem with one entry of its Jacobian multiplied.
struct Tampered<'a> {
    right: &'a Written<'a>,
    row: usize,
    column: usize,
    factor: f64,
}

impl Problem for Tampered<'_> {
    type Point = DVector<f64>;

    fn residual_count(&self) -> usize {
        self.right.residual_count()
    }

    fn tangent_dim(&self) -> usize {
        self.right.tangent_dim()
    }

    fn residuals(&self, at: &DVector<f64>, out: &mut DVector<f64>) {
        self.right.residuals(at, out);
    }

    fn jacobian(&self, at: &DVector<f64>, out: &mut DMatrix<f64>) {
        self.right.jacobian(at, out);
        out[(self.row, self.column)] *= self.factor;
    }

    fn retract(&self, at: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        self.right.retract(at, step)
    }
}

#[test]
fn a_wrong_entry_is_found_and_named() {
    let data = decay_data(|_| 0.0);
    let right = decay(&data);
    let at = DVector::from_vec(vec![1.5, 0.6, 0.1]);
    for (row, column) in [(0, 0), (3, 1), (11, 2)] {
        for factor in [-1.0, 0.0, 1e6, 1.0 + 1e-5, f64::NAN] {
            let check = check_jacobian(&Tampered { right: &right, row, column, factor }, &at);
            assert_eq!((check.worst.row, check.worst.column), (row, column), "{factor}: {check}");
            let passes = check.worst_relative_error() < AGREEMENT;
            assert!(!passes, "{factor}: {check}");
        }
    }
}

/// Positions of 1e5 mm in steps of nanometres: the residual is small, what it is made of is not.
#[test]
fn large_offsets_leave_enough_digits() {
    let problem = Written::new(&["x", "y"], 2, |p| {
        let radius = (p[0].square() + p[1].square()).sqrt();
        vec![(radius - 1e5) / 1e-3, (p[0] - p[1] * 0.5) / 1e-3]
    });
    let check = check_jacobian(&problem, &DVector::from_vec(vec![8e4, 6e4]));
    assert!(check.worst_relative_error() < AGREEMENT, "{check}");
}

#[test]
fn the_message_says_where_and_what() {
    let data = decay_data(|_| 0.0);
    let right = decay(&data);
    let at = DVector::from_vec(vec![1.5, 0.6, 0.1]);
    let check = check_jacobian(&Tampered { right: &right, row: 2, column: 2, factor: -1.0 }, &at);
    let text = check.to_string();
    assert!(text.contains("residual 2 by parameter 2 (direction 2)"), "{text}");
    assert!(text.contains("analytic -1e0"), "{text}");
}
