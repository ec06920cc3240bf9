//! Whether a pose found can be true of a machine.

use nalgebra::Matrix3;

use crate::Error;
use crate::implausible::ImplausibleResult;

/// Farthest from the machine's zero that a workpiece lies: the bed of the longest gantry.
const MAX_PLACE_MM: f64 = 1e5;

/// Largest share by which the axes of a machine are wrong in length or square: what is found of
/// better ones without any compensation is a tenth of it.
const MAX_AXES: f64 = 0.02;

/// A part beyond the bed of any machine.
pub(super) fn too_far(place_mm: [f64; 3]) -> Option<ImplausibleResult> {
    let found_mm = place_mm.iter().map(|v| v * v).sum::<f64>().sqrt();
    let limit_mm = MAX_PLACE_MM;
    (found_mm > limit_mm).then_some(ImplausibleResult::Place { found_mm, limit_mm })
}

/// A pose alone keeps lengths and angles: what its matrix does to them is the axes' doing.
pub(super) fn bad_axes(linear: &Matrix3<f64>) -> Option<ImplausibleResult> {
    let mut strain = linear.transpose() * linear - Matrix3::identity();
    // Squares of lengths change twice as much as lengths.
    strain.set_diagonal(&(0.5 * strain.diagonal()));
    let (found, limit) = (strain.amax(), MAX_AXES);
    (found > limit).then_some(ImplausibleResult::Axes { found, limit })
}

/// Refuses a matrix from workpiece to readings whose axes are worse than those of any machine.
pub(crate) fn plausible_reading(linear: &Matrix3<f64>) -> Result<(), Error> {
    bad_axes(linear)
        .map_or(Ok(()), |problem| Err(Error::Implausible { problem: Box::new(problem) }))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Rotation3};

    use super::{bad_axes, too_far};
    use crate::implausible::ImplausibleResult;

    #[test]
    fn axes_of_a_turned_part_may_be_wrong_by_a_hundredth_and_not_by_all() {
        let turned = Rotation3::from_euler_angles(0.3, -0.2, 0.5).into_inner();
        let mut long = Matrix3::identity();
        long[(0, 0)] = 1.01;
        assert_eq!(bad_axes(&turned), None);
        assert_eq!(bad_axes(&(long * turned)), None);
        long[(0, 0)] = 0.5;
        let found = bad_axes(&(long * turned));
        assert!(matches!(found, Some(ImplausibleResult::Axes { .. })), "{found:?}");
    }

    #[test]
    fn a_workpiece_beyond_the_horizon_is_named() {
        assert_eq!(too_far([4e4, -2e4, 900.0]), None);
        let found = too_far([0.0, 3e6, 0.0]).expect("three kilometres");
        assert!(found.to_string().contains("lies 3000 m from the zero"), "{found}");
    }
}
