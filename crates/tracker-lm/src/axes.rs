//! What the errors of all angles say of where the axes are, and of how two lie to each other.

use nalgebra::{
    DMatrix, Matrix2, Matrix2x4, Matrix4, Point3, RowVector4, SMatrix, Unit, Vector3, Vector4,
};

use crate::location::{AngleFit, AxisLocation, angle_fit, located};
use crate::network::Network;
use crate::{RotaryAxis, SecondAxis};

/// How the two axes of a head lie to each other, beside how they should.
///
/// The frame of the stations is in neither number. With B on C, `direction` is along x: the offset
/// is EX0B − EX0C and the angle EA0B − EA0C, the squareness of B to C.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AxesRelation {
    /// Across both axes, machine frame; its largest coordinate is positive.
    pub direction: Unit<Vector3<f64>>,
    /// From the first axis to the second along it, as declared.
    pub nominal_offset_mm: f64,
    /// Angle between the declared directions, 0 to π.
    pub nominal_angle_rad: f64,
    /// Offset of the second axis from the first along `direction`, beyond what is declared.
    pub offset_error_mm: f64,
    /// Rotation of the second axis against the first about `direction`, beyond what is declared.
    pub rotation_error_rad: f64,
    /// Covariance of the two.
    pub covariance: Matrix2<f64>,
}

/// Sine of the angle between two axes below which they have no direction across both.
const PARALLEL: f64 = 1e-3;

/// What is summed over the angles of a network.
pub(crate) struct LocationSums {
    /// The location of every axis; `None` where its angles hardly differ.
    pub(crate) of_axis: Vec<Option<AngleFit>>,
    /// How two lie to each other, in the first two sums.
    pub(crate) relation: Option<AngleFit>,
}

impl LocationSums {
    pub(crate) fn new(network: &Network<'_>) -> Self {
        let of_axis: Vec<_> = (0..network.axis_count()).map(|axis| fit(network, axis)).collect();
        let relation = match (&network.survey.second, &of_axis[..]) {
            (Some(second), [Some(first), Some(on_it)]) => Across::of(&network.survey.axis, second)
                .map(|across| {
                    let [by_first, by_second] = across.by_location(&network.survey.axis, second);
                    let sum = |(a, b): (&SMatrix<f64, 4, 6>, &SMatrix<f64, 4, 6>)| {
                        let mut rows = SMatrix::<f64, 4, 6>::zeros();
                        rows.fixed_rows_mut::<2>(0).copy_from(&(by_second * b - by_first * a));
                        rows
                    };
                    first.iter().zip(on_it).map(sum).collect()
                }),
            _ => None,
        };
        Self { of_axis, relation }
    }
}

/// Sums that give the location of an axis, zero at the angles of the other one.
fn fit(network: &Network<'_>, axis: usize) -> Option<AngleFit> {
    angle_fit(network.axis(axis), network.angles_of(axis), network.angles.len())
}

/// The location of an axis from its sums.
pub(crate) fn location(
    network: &Network<'_>,
    axis: usize,
    (errors, covariance): (Vector4<f64>, Matrix4<f64>),
) -> AxisLocation {
    let first_rad = network.angles_of(axis).next().map_or(0.0, |(_, angle_rad)| angle_rad);
    located(*network.axis(axis), first_rad, errors, covariance)
}

/// How two axes lie to each other, from the sums.
pub(crate) fn relation(
    network: &Network<'_>,
    (errors, covariance): (Vector4<f64>, Matrix4<f64>),
) -> Option<AxesRelation> {
    let second = network.survey.second.as_ref()?;
    let across = Across::of(&network.survey.axis, second)?;
    Some(AxesRelation {
        direction: across.direction,
        nominal_offset_mm: across.offset_mm,
        nominal_angle_rad: across.angle_rad,
        offset_error_mm: errors[0],
        rotation_error_rad: errors[1],
        covariance: covariance.fixed_view::<2, 2>(0, 0).into_owned(),
    })
}

/// The direction across two axes.
struct Across {
    direction: Unit<Vector3<f64>>,
    offset_mm: f64,
    angle_rad: f64,
    /// Where the axes are nearest to each other.
    nearest_mm: [Point3<f64>; 2],
}

impl Across {
    fn of(first: &RotaryAxis, second: &SecondAxis) -> Option<Self> {
        let (a, b) = (first.direction.into_inner(), second.axis.direction.into_inner());
        let normal = a.cross(&b);
        let sine = normal.norm();
        if sine < PARALLEL {
            return None;
        }
        let normal = normal / sine;
        let sign = normal[normal.iamax()].signum();
        let between = second.axis.origin_mm - first.origin_mm;
        let along_first = between.cross(&b).dot(&normal) / sine;
        let along_second = between.cross(&a).dot(&normal) / sine;
        Some(Self {
            direction: Unit::new_unchecked(normal * sign),
            offset_mm: between.dot(&(normal * sign)),
            angle_rad: sine.atan2(a.dot(&b)),
            nearest_mm: [
                first.origin_mm + a * along_first,
                second.axis.origin_mm + b * along_second,
            ],
        })
    }

    /// Displacement along the direction and rotation about it of each axis, where the axes are
    /// nearest to each other, by its errors of location.
    fn by_location(&self, first: &RotaryAxis, second: &SecondAxis) -> [Matrix2x4<f64>; 2] {
        let normal = self.direction.into_inner();
        let of = |axis: &RotaryAxis, nearest: &Point3<f64>| {
            let arm = nearest - axis.origin_mm;
            let [i, j] = axis.letter.across().map(|c| Vector3::ith(c, 1.0));
            let lever = |turn: &Vector3<f64>| normal.dot(&turn.cross(&arm));
            Matrix2x4::from_rows(&[
                RowVector4::new(normal.dot(&i), normal.dot(&j), lever(&i), lever(&j)),
                RowVector4::new(0.0, 0.0, normal.dot(&i), normal.dot(&j)),
            ])
        };
        [of(first, &self.nearest_mm[0]), of(&second.axis, &self.nearest_mm[1])]
    }
}

/// Sums over angles whose errors follow shared parameters and have a covariance of their own.
pub(crate) fn summed<'e>(
    fit: &AngleFit,
    angles: impl Iterator<Item = (&'e nalgebra::Vector6<f64>, &'e DMatrix<f64>, &'e DMatrix<f64>)>,
    covariance: &DMatrix<f64>,
) -> (Vector4<f64>, Matrix4<f64>) {
    let mut sum = Vector4::zeros();
    let mut all = DMatrix::zeros(4, 4);
    let mut along = DMatrix::zeros(4, covariance.nrows());
    for (matrix, (error, own, follows)) in fit.iter().zip(angles) {
        sum += matrix * error;
        all += matrix * own * matrix.transpose();
        along += matrix * follows;
    }
    let spread = all + &along * covariance * along.transpose();
    (sum, Matrix4::from_iterator(spread.iter().copied()))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::*;
    use crate::AxisLetter;

    /// A B axis 30 mm along x and 200 mm below a C axis, which stands a little out of square.
    #[test]
    fn offset_and_angle_are_those_of_the_lines() {
        let place = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
        let c = RotaryAxis::new(AxisLetter::C, place(10.0, 20.0, 500.0), Vector3::z()).unwrap();
        let b = RotaryAxis::new(AxisLetter::B, place(40.0, 150.0, 300.0), Vector3::y()).unwrap();
        let second = SecondAxis { axis: b, angles_rad: Vec::new() };
        let across = Across::of(&c, &second).unwrap();
        assert!((across.direction.x - 1.0).abs() < 1e-12 && (across.offset_mm - 30.0).abs() < 1e-9);
        assert!((across.nearest_mm[0] - place(10.0, 20.0, 300.0)).norm() < 1e-9);
        assert!((across.nearest_mm[1] - place(40.0, 20.0, 300.0)).norm() < 1e-9);
        let [by_c, by_b] = across.by_location(&c, &second);
        // C displaced along x and tilted about y: 200 mm below its origin it is elsewhere in x.
        let of_c = by_c * Vector4::new(0.004, 0.0, 5e-6, 20e-6);
        assert!(
            (of_c[0] - (0.004 - 20e-6 * 200.0)).abs() < 1e-12 && (of_c[1] - 5e-6).abs() < 1e-15
        );
        // B turned about z: 130 mm along it, towards the C axis, it is elsewhere in x.
        let of_b = by_b * Vector4::new(0.0, 0.003, 7e-6, 10e-6);
        assert!((of_b[0] - 10e-6 * 130.0).abs() < 1e-12 && (of_b[1] - 7e-6).abs() < 1e-15);
    }
}
