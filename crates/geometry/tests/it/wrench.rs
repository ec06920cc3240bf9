//! Wrenches: transport, power, line of action.

use geometry::nalgebra::{Isometry3, Point3, Vector3, Vector6};
use geometry::{GeometryError, Wrench, se3};
use proptest::prelude::*;

use crate::seeded;

/// Forces up to 100 N at arms up to 1e3 mm: 1e5 N·mm · 2⁻⁵² · 32.
const TORQUE_TOL_NMM: f64 = 1e5 * 32.0 * f64::EPSILON;

/// 100 N · 2⁻⁵² · 32.
const FORCE_TOL_N: f64 = 100.0 * 32.0 * f64::EPSILON;

fn vectors(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-size..size).prop_map(Vector3::from)
}

fn wrenches() -> impl Strategy<Value = Wrench> {
    (vectors(100.0), vectors(1e4)).prop_map(|(force_n, torque_nmm)| Wrench { force_n, torque_nmm })
}

fn poses() -> impl Strategy<Value = Isometry3<f64>> {
    (vectors(500.0), vectors(1.8)).prop_map(|(t, r)| Isometry3::new(t, r))
}

proptest! {
    #![proptest_config(seeded(512))]

    #[test]
    fn power_is_the_same_in_every_frame(
        wrench in wrenches(), pose in poses(), v in vectors(100.0), w in vectors(0.1),
    ) {
        let twist = Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z);
        let there = wrench.in_frame(&pose).power_nmm_per_s(&(se3::adjoint(&pose) * twist));
        // 1e5 N·mm at 0.1 rad/s, or 100 N at 100 mm/s.
        prop_assert!((there - wrench.power_nmm_per_s(&twist)).abs() < TORQUE_TOL_NMM);
    }

    #[test]
    fn change_of_frame_is_the_transposed_adjoint(wrench in wrenches(), pose in poses()) {
        let expected = se3::adjoint(&pose.inverse()).transpose() * wrench.to_vector();
        let moved = wrench.in_frame(&pose);
        prop_assert!((moved.force_n - expected.fixed_rows::<3>(0)).norm() < FORCE_TOL_N);
        prop_assert!((moved.torque_nmm - expected.fixed_rows::<3>(3)).norm() < TORQUE_TOL_NMM);
        let back = moved.in_frame(&pose.inverse());
        prop_assert!((back.torque_nmm - wrench.torque_nmm).norm() < TORQUE_TOL_NMM);
    }

    #[test]
    fn moving_the_reference_is_a_translated_frame(wrench in wrenches(), p in vectors(1e3)) {
        let reference = Point3::from(p);
        let moved = wrench.about(&reference);
        let frame = Isometry3::translation(-p.x, -p.y, -p.z);
        prop_assert!((moved.torque_nmm - wrench.in_frame(&frame).torque_nmm).norm() == 0.0);
        let back = moved.about(&Point3::from(-p));
        prop_assert!((back.torque_nmm - wrench.torque_nmm).norm() < TORQUE_TOL_NMM);
    }

    #[test]
    fn line_of_action_carries_force_and_free_moment(wrench in wrenches()) {
        let action = wrench.line_of_action().unwrap();
        let point = action.line.point_mm;
        prop_assert!((action.force_n - wrench.force_n.norm()).abs() < FORCE_TOL_N);
        // Closest to the origin, and the moment about it is along the force.
        let arm = point.coords.norm();
        prop_assert!(point.coords.dot(&action.line.direction).abs() <= 8.0 * f64::EPSILON * arm);
        let left = wrench.about(&action.line.at(37.0)).torque_nmm;
        let along = action.line.direction.into_inner() * action.free_torque_nmm;
        prop_assert!((left - along).norm() < TORQUE_TOL_NMM);
    }

    #[test]
    fn a_single_force_acts_through_its_point(force in vectors(100.0), p in vectors(500.0)) {
        let action = Wrench::of_force(force, &Point3::from(p)).line_of_action().unwrap();
        let off = (p - action.line.point_mm.coords).cross(&action.line.direction).norm();
        prop_assert!(off < TORQUE_TOL_NMM / force.norm().max(1.0) + 1e-10, "{off}");
        prop_assert!(action.free_torque_nmm.abs() < TORQUE_TOL_NMM);
    }
}

#[test]
fn a_pressed_point_is_found_on_the_contact_plane() {
    // Document [A], eq. 1.11: x0 = (z0 Fx − My)/Fz, y0 = (Mx + z0 Fy)/Fz.
    let contact = Point3::new(12.0, -7.0, 25.0);
    let wrench = Wrench::of_force(Vector3::new(1.5, -0.8, -40.0), &contact);
    let (f, m) = (wrench.force_n, wrench.torque_nmm);
    let x0 = (contact.z * f.x - m.y) / f.z;
    let y0 = (m.x + contact.z * f.y) / f.z;
    let line = wrench.line_of_action().unwrap().line;
    let on_plane = line.at((contact.z - line.point_mm.z) / line.direction.z);
    assert!((on_plane - Point3::new(x0, y0, contact.z)).norm() < 1e-13);
    assert!((on_plane - contact).norm() < 1e-13);
}

#[test]
fn arithmetic_is_componentwise() {
    let a = Wrench::from_vector(&Vector6::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0));
    let mut sum = a;
    sum += a;
    assert_eq!(sum, a * 2.0);
    sum -= a;
    assert_eq!(sum, a);
    assert_eq!(a - a, Wrench::default());
    assert_eq!((-a).to_vector(), -a.to_vector());
}

#[test]
fn couples_and_broken_numbers_have_no_line() {
    let couple = Wrench { force_n: Vector3::zeros(), torque_nmm: Vector3::z() };
    assert!(matches!(couple.line_of_action(), Err(GeometryError::NoForce { .. })));
    for broken in [f64::NAN, f64::INFINITY, 1e200] {
        let wrench = Wrench { force_n: Vector3::x() * broken, torque_nmm: Vector3::z() };
        assert!(matches!(wrench.line_of_action(), Err(GeometryError::NonFinite { .. })));
    }
    // A very light touch still has an axis: 1e-9 N at 5 mm.
    let touch = Wrench::of_force(Vector3::new(0.0, 0.0, -1e-9), &Point3::new(3.0, 4.0, 0.0));
    let point = touch.line_of_action().unwrap().line.point_mm;
    assert!((point - Point3::new(3.0, 4.0, 0.0)).norm() < 1e-14);
}
