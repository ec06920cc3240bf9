//! What comes out of a perfect axis with amplitudes of location and motion.

use geometry::so3;
use nalgebra::{DMatrix, Matrix3, Matrix4, Matrix6, Point3, Vector3, Vector4, Vector6};

use crate::curves::{Curves, Shape};
use crate::error_order::in_order;
use crate::frame::Frame;
use crate::location::{AxisLocation, located};
use crate::{AxisError, ErrorOrder, MountEstimate, RotaryAxis};

/// An axis whose errors are functions of the angle.
#[derive(Clone, Debug)]
pub(crate) struct PerfectAxis<'a> {
    pub(crate) axis: &'a RotaryAxis,
    pub(crate) angles_rad: &'a [f64],
    pub(crate) curves: &'a Curves,
    pub(crate) amplitudes: &'a [f64],
    /// Of the amplitudes.
    pub(crate) covariance: DMatrix<f64>,
}

/// The part of a covariance that belongs to some of its parameters.
pub(crate) fn selected(covariance: &DMatrix<f64>, of: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(of.len(), of.len(), |i, j| covariance[(of[i], of[j])])
}

impl PerfectAxis<'_> {
    /// With the uncertainty of the frame in that of the axis' place, where it is not as declared.
    pub(crate) fn in_frame(mut self, frame: &Frame) -> Self {
        for (i, first) in self.curves.shapes.iter().enumerate() {
            for (j, second) in self.curves.shapes.iter().enumerate() {
                if let (Shape::Location(c), Shape::Location(d)) = (first, second) {
                    self.covariance[(i, j)] += frame.covariance[(*c, *d)];
                }
            }
        }
        self
    }

    /// The six errors of the declared axis relative to the first angle, location and motion together.
    pub(crate) fn errors(&self, order: ErrorOrder) -> Vec<AxisError> {
        let first = self.curves.at(0, self.amplitudes);
        let from_first = -rotation_of(&first.error);
        let of = |(k, &angle_rad): (usize, &f64)| {
            let here = self.curves.at(k, self.amplitudes);
            let since = self.axis.rotation(angle_rad - self.angles_rad[0]);
            let turned = so3::exp(&rotation_of(&here.error)) * so3::exp(&(since * from_first));
            let moved =
                displacement_of(&here.error) - turned * (since * displacement_of(&first.error));
            let turn = so3::log(&turned);
            let back = since.to_rotation_matrix().into_inner();
            let pairs = here.slopes.iter().zip(&first.slopes);
            let follows: Vec<Vector6<f64>> =
                pairs.map(|(here, first)| here - both_turned(&back, first)).collect();
            self.error(angle_rad, joined(&moved, &turn), &follows, order)
        };
        self.angles_rad.iter().enumerate().map(of).collect()
    }

    /// The motion errors about the axis where it is.
    pub(crate) fn motion(&self, order: ErrorOrder) -> Vec<AxisError> {
        let of = |(k, &angle_rad): (usize, &f64)| {
            let mut error = Vector6::zeros();
            let mut follows = vec![Vector6::zeros(); self.curves.len()];
            for (i, shape) in self.curves.shapes.iter().enumerate() {
                if let Shape::Motion(by_angle) = shape {
                    error += by_angle[k] * self.amplitudes[i];
                    follows[i] = by_angle[k];
                }
            }
            self.error(angle_rad, error, &follows, order)
        };
        self.angles_rad.iter().enumerate().map(of).collect()
    }

    /// Where the axis is; `None` where that is as declared.
    pub(crate) fn location(&self) -> Option<AxisLocation> {
        let (mut errors, mut which) = (Vector4::zeros(), [None; 4]);
        for (i, shape) in self.curves.shapes.iter().enumerate() {
            if let Shape::Location(c) = shape {
                errors[*c] = self.amplitudes[i];
                which[*c] = Some(i);
            }
        }
        which.iter().any(Option::is_some).then(|| {
            let covariance = Matrix4::from_fn(|i, j| match (which[i], which[j]) {
                (Some(i), Some(j)) => self.covariance[(i, j)],
                _ => 0.0,
            });
            located(*self.axis, self.angles_rad[0], errors, covariance)
        })
    }

    /// A reflector as the errors relative to the first angle have it; `covariance` is that of its
    /// place and of the amplitudes.
    pub(crate) fn mount(&self, place: &Vector3<f64>, covariance: &DMatrix<f64>) -> MountEstimate {
        let first = self.curves.at(0, self.amplitudes);
        let nominal = self.axis.rotation(self.angles_rad[0]).to_rotation_matrix().into_inner();
        let turn = rotation_of(&first.error);
        let turned = so3::exp(&turn).to_rotation_matrix().into_inner();
        let arm = turned * (nominal * place);
        let mut follows = DMatrix::zeros(3, 3 + self.curves.len());
        let by_place = nominal.tr_mul(&(turned * nominal));
        follows.fixed_view_mut::<3, 3>(0, 0).copy_from(&by_place);
        for (i, slope) in first.slopes.iter().enumerate() {
            let turning = so3::left_jacobian(&turn) * rotation_of(slope);
            let moved = displacement_of(slope) + turning.cross(&arm);
            follows.fixed_view_mut::<3, 1>(0, 3 + i).copy_from(&nominal.tr_mul(&moved));
        }
        let spread = &follows * covariance * follows.transpose();
        MountEstimate {
            position_mm: Point3::from(nominal.tr_mul(&(arm + displacement_of(&first.error)))),
            covariance_mm2: Matrix3::from_iterator(spread.iter().copied()),
        }
    }

    fn error(
        &self,
        angle_rad: f64,
        error: Vector6<f64>,
        follows: &[Vector6<f64>],
        order: ErrorOrder,
    ) -> AxisError {
        let follows = DMatrix::from_fn(6, follows.len(), |i, j| follows[j][i]);
        let spread = &follows * &self.covariance * follows.transpose();
        let covariance = Matrix6::from_iterator(spread.iter().copied());
        in_order(self.axis, order, AxisError { angle_rad, error, covariance })
    }
}

fn displacement_of(error: &Vector6<f64>) -> Vector3<f64> {
    error.fixed_rows::<3>(0).into_owned()
}

fn rotation_of(error: &Vector6<f64>) -> Vector3<f64> {
    error.fixed_rows::<3>(3).into_owned()
}

fn joined(displacement: &Vector3<f64>, rotation: &Vector3<f64>) -> Vector6<f64> {
    Vector6::from_iterator(displacement.iter().chain(rotation.iter()).copied())
}

fn both_turned(by: &Matrix3<f64>, error: &Vector6<f64>) -> Vector6<f64> {
    joined(&(by * displacement_of(error)), &(by * rotation_of(error)))
}
