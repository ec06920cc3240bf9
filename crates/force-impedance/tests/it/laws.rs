//! What holds at every pose and for every reading of the cells.

use nalgebra::{Matrix3, Point3, Vector3, Vector4};
use proptest::prelude::*;

use crate::usual_head::head;

/// Forces of 300 N through a dozen operations.
const EXACT_N: f64 = 1e-11;
/// The same through normal equations of a condition below 1e3.
const SOLVED_N: f64 = 1e-8;

fn cells() -> impl Strategy<Value = [f64; 4]> {
    [-300.0..300.0, -300.0..300.0, -300.0..300.0, -300.0..300.0]
}

/// Off the straight head by what the legs allow.
fn tips() -> impl Strategy<Value = Point3<f64>> {
    [-10.0..10.0, -5.0..5.0, -10.0..10.0]
        .prop_map(|off_mm| head().start_tip_mm() + Vector3::from(off_mm))
}

proptest! {
    /// The force is the weight's and a sum over the cells, each by its influence.
    #[test]
    fn the_force_is_linear_in_the_cells(
        tip_mm in tips(), one in cells(), other in cells(), share in -2.0..2.0_f64,
    ) {
        let head = head();
        let balance = head.balance(&head.pose_at(&tip_mm).unwrap());
        let mixed: [f64; 4] = std::array::from_fn(|i| one[i] + share * other[i]);
        let of = |cells_n: &[f64; 4]| -> Vector3<f64> { balance.force_n(cells_n) - balance.of_weight_n() };
        let sum = of(&one) + of(&other) * share;
        prop_assert!((of(&mixed) - sum).norm() < EXACT_N);
        let by_influence = balance.influence() * Vector4::from(one);
        prop_assert!((of(&one) - by_influence).norm() < EXACT_N);
    }

    /// Normal force and friction are the two parts of the force; the normal force is also the sum
    /// of the cells by its weights.
    #[test]
    fn the_parts_of_the_force_make_the_force(
        tip_mm in tips(), cells_n in cells(), tilt in [-0.7..0.7, -0.7..0.7],
    ) {
        let head = head();
        let balance = head.balance(&head.pose_at(&tip_mm).unwrap());
        let normal = Vector3::new(tilt[0], 1.0, tilt[1]).normalize();
        let contact = balance.contact(&cells_n, &normal);
        prop_assert!((contact.force_n - balance.force_n(&cells_n)).norm() < EXACT_N);
        let parts_n = contact.normal_n.hypot(contact.tangential_n);
        prop_assert!((parts_n - contact.force_n.norm()).abs() < EXACT_N);
        let weights = Vector4::from(balance.normal_weights(&normal));
        let normal_n = weights.dot(&Vector4::from(cells_n)) + balance.of_weight_n().dot(&normal);
        prop_assert!((contact.normal_n - normal_n).abs() < EXACT_N);
        prop_assert_eq!(contact.friction_ratio.is_some(), contact.normal_n > 0.0);
    }

    /// Readings that stand for a contact force and a preload give them back.
    #[test]
    fn a_force_and_a_preload_are_four_readings(tip_mm in tips(), cells_n in cells()) {
        let head = head();
        let balance = head.balance(&head.pose_at(&tip_mm).unwrap());
        let force_n = balance.force_n(&cells_n);
        let found = balance.cells_n(&force_n, balance.preload_n(&cells_n)).unwrap();
        for (found, read) in found.iter().zip(&cells_n) {
            prop_assert!((found - read).abs() < SOLVED_N);
        }
        prop_assert_eq!(balance.cells_n(&(force_n * f64::NAN), 0.0), None);
    }

    /// A preload is what moves no contact force, and the covariance is that of a linear function.
    #[test]
    fn what_the_force_does_not_see_is_the_preload(
        tip_mm in tips(), cells_n in cells(), sigma_n in [0.1..2.0, 0.1..2.0, 0.1..2.0, 0.1..2.0],
    ) {
        let head = head();
        let balance = head.balance(&head.pose_at(&tip_mm).unwrap());
        let influence = balance.influence();
        let unit = Vector4::from_fn(|i, _| {
            balance.preload_n(&std::array::from_fn(|k| f64::from(u8::from(k == i))))
        });
        prop_assert!((unit.norm() - 1.0).abs() < 1e-12);
        prop_assert!((influence * unit).norm() < 1e-12);
        let preload_n = balance.preload_n(&cells_n);
        let released: [f64; 4] = std::array::from_fn(|i| cells_n[i] - preload_n * unit[i]);
        prop_assert!((balance.force_n(&released) - balance.force_n(&cells_n)).norm() < EXACT_N);
        prop_assert!(balance.preload_n(&released).abs() < EXACT_N);
        let expected: Matrix3<f64> = (0..4)
            .map(|i| {
                let column: Vector3<f64> = influence.column(i) * sigma_n[i];
                column * column.transpose()
            })
            .sum();
        prop_assert!((balance.covariance_n2(&sigma_n) - expected).amax() < 1e-12 * expected.amax());
    }
}
