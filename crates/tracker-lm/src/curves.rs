//! Errors of the axis as functions of its angle, with a few amplitudes.
//!
//! An axis displaced by d and tilted by τ turns a reflector about another line than the declared
//! one: `o + d + exp(τ)·R·exp(−τ)·(t − d)`. As six errors of the declared axis that is
//! `ω = log(exp(τ)·exp(−R·τ))`, `e = d − exp(ω)·R·d`. Motion errors add to these in proportion to
//! their amplitudes.

use geometry::so3;
use nalgebra::{Matrix3, Vector3, Vector6};

use crate::RotaryAxis;

/// What one amplitude does to the six errors.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Shape {
    /// Displacement (0, 1) or tilt (2, 3) of the axis along or about a machine axis across it.
    Location(usize),
    /// In proportion: `[x y z a b c]` per unit, angle by angle.
    Motion(Vec<Vector6<f64>>),
}

/// Six errors at every angle as a function of amplitudes.
#[derive(Clone, Debug)]
pub(crate) struct Curves {
    across: [usize; 2],
    /// Nominal rotation at each angle; empty where no amplitude is of the location.
    rotations: Vec<Matrix3<f64>>,
    pub(crate) shapes: Vec<Shape>,
}

/// The six errors at an angle, and their derivatives by the amplitudes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ErrorsAt {
    pub(crate) error: Vector6<f64>,
    pub(crate) slopes: Vec<Vector6<f64>>,
}

/// Location errors of an axis.
pub(crate) const LOCATION: [Shape; 4] =
    [Shape::Location(0), Shape::Location(1), Shape::Location(2), Shape::Location(3)];

impl Curves {
    pub(crate) fn new(axis: &RotaryAxis, angles_rad: &[f64], shapes: Vec<Shape>) -> Self {
        let rotation = |a: &f64| axis.rotation(*a).to_rotation_matrix().into_inner();
        let has_location = shapes.iter().any(|shape| matches!(shape, Shape::Location(_)));
        let angles_rad = if has_location { angles_rad } else { &[] };
        let rotations = angles_rad.iter().map(rotation).collect();
        Self { across: axis.letter.across(), rotations, shapes }
    }

    pub(crate) fn len(&self) -> usize {
        self.shapes.len()
    }

    /// The six errors at an angle.
    pub(crate) fn error(&self, angle: usize, amplitudes: &[f64]) -> Vector6<f64> {
        let mut error = self.located(angle, amplitudes).map_or_else(Vector6::zeros, |l| l.error);
        for (shape, amplitude) in self.shapes.iter().zip(amplitudes) {
            if let Shape::Motion(by_angle) = shape {
                error += by_angle[angle] * *amplitude;
            }
        }
        error
    }

    /// The six errors at an angle with their derivatives.
    pub(crate) fn at(&self, angle: usize, amplitudes: &[f64]) -> ErrorsAt {
        let located = self.located(angle, amplitudes);
        let slope = |shape: &Shape| match (shape, &located) {
            (Shape::Location(c), Some(located)) => located.slope(*c, self.across),
            (Shape::Motion(by_angle), _) => by_angle[angle],
            (Shape::Location(_), None) => Vector6::zeros(),
        };
        let slopes = self.shapes.iter().map(slope).collect();
        ErrorsAt { error: self.error(angle, amplitudes), slopes }
    }

    /// What a displaced and tilted axis makes at an angle; `None` where none of it is an amplitude.
    fn located(&self, angle: usize, amplitudes: &[f64]) -> Option<Located> {
        let (mut displaced, mut tilt) = (Vector3::zeros(), Vector3::zeros());
        let mut is_any = false;
        for (shape, amplitude) in self.shapes.iter().zip(amplitudes) {
            let Shape::Location(c) = shape else { continue };
            is_any = true;
            let part = if *c < 2 { &mut displaced } else { &mut tilt };
            part[self.across[c % 2]] += *amplitude;
        }
        is_any.then(|| Located::new(self.rotations[angle], displaced, tilt))
    }
}

/// Errors that a displaced and tilted axis makes at an angle.
struct Located {
    error: Vector6<f64>,
    rotation: Matrix3<f64>,
    turn: Vector3<f64>,
    turned: Matrix3<f64>,
    arm: Vector3<f64>,
    tilt: Vector3<f64>,
}

impl Located {
    fn new(rotation: Matrix3<f64>, displaced: Vector3<f64>, tilt: Vector3<f64>) -> Self {
        let turn = so3::log(&(so3::exp(&tilt) * so3::exp(&-(rotation * tilt))));
        let turned = so3::exp(&turn).to_rotation_matrix().into_inner();
        let arm = turned * (rotation * displaced);
        let moved = displaced - arm;
        let error = Vector6::new(moved.x, moved.y, moved.z, turn.x, turn.y, turn.z);
        Self { error, rotation, turn, turned, arm, tilt }
    }

    /// Derivative by one of the four.
    fn slope(&self, c: usize, across: [usize; 2]) -> Vector6<f64> {
        let along = Vector3::ith(across[c % 2], 1.0);
        if c < 2 {
            let moved = along - self.turned * (self.rotation * along);
            return Vector6::new(moved.x, moved.y, moved.z, 0.0, 0.0, 0.0);
        }
        let back = -(self.rotation * self.tilt);
        let left = so3::left_jacobian(&self.tilt) * along;
        let right = so3::left_jacobian(&back) * (self.rotation * along);
        // Small rotation on the left of exp(ω).
        let turn = left - so3::exp(&self.tilt) * right;
        let own = so3::left_jacobian_inverse(&self.turn) * turn;
        let moved = self.arm.cross(&turn);
        Vector6::new(moved.x, moved.y, moved.z, own.x, own.y, own.z)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3, Translation3};

    use super::*;
    use crate::AxisLetter;

    fn curves() -> (RotaryAxis, Curves) {
        let origin = Point3::new(4.0, -3.0, 7.0);
        let axis = RotaryAxis::new(AxisLetter::B, origin, Vector3::new(0.1, 1.0, -0.05)).unwrap();
        let motion =
            Shape::Motion(vec![Vector6::repeat(0.3), Vector6::new(1., 2., 3., 4., 5., 6.)]);
        let shapes = LOCATION.into_iter().chain([motion]).collect();
        let curves = Curves::new(&axis, &[-0.4, 1.9], shapes);
        (axis, curves)
    }

    /// Numbers of size 10, a few dozen operations.
    const ROUND_OFF: f64 = 1e-13;

    #[test]
    fn a_moved_axis_turns_points_about_its_own_line() {
        let (axis, curves) = curves();
        let errors = curves.error(1, &[0.3, -0.2, 0.02, 0.01, 0.0]);
        let at = axis.origin_mm + Vector3::new(0.3, 0.0, -0.2);
        let tilt = so3::exp(&Vector3::new(0.02, 0.0, 0.01));
        let line = Isometry3::from_parts(Translation3::from(at.coords), tilt);
        let turned = line * Isometry3::from_parts(Translation3::identity(), axis.rotation(1.9));
        let point = Point3::new(150.0, -40.0, 90.0);
        let expected = turned * (line.inverse() * point);
        let arm = axis.rotation(1.9) * (point - axis.origin_mm);
        let rotation = errors.fixed_rows::<3>(3).into_owned();
        let found = axis.origin_mm + errors.fixed_rows::<3>(0) + so3::exp(&rotation) * arm;
        assert!((found - expected).norm() < 1e3 * ROUND_OFF, "{found} {expected}");
    }

    #[test]
    fn slopes_are_derivatives() {
        // Central differences: rounding over the step beside its square.
        const STEP: f64 = 1e-5;
        let (_, curves) = curves();
        let amplitudes = [0.3, -0.2, 0.02, 0.01, 0.1];
        let at = curves.at(1, &amplitudes);
        for (i, slope) in at.slopes.iter().enumerate() {
            let moved = |by: f64| {
                let mut amplitudes = amplitudes;
                amplitudes[i] += by;
                curves.error(1, &amplitudes)
            };
            let difference = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
            assert!((difference - slope).amax() < 1e-9, "{i}: {difference} {slope}");
        }
    }
}
