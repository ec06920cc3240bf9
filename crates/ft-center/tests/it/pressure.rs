//! One wrench: (1.11) of [A], its signs, its gate and what Mz would do to it.

use ft_center::{FtCenterError, center_of_pressure};
use geometry::Wrench;
use nalgebra::{DMatrix, DVector, Point2, Vector3};
use proptest::prelude::*;

use crate::simulator::{Z0_MM, wrench_at};

/// Round-off of (1.11): terms up to 1e5 N·mm over 5 N, 2⁻⁵² · 10 operations.
const EXACT_TOL_MM: f64 = 1e-10;

proptest! {
    #[test]
    fn finds_the_point_and_the_couple(
        x in -300.0..300.0f64, y in -300.0..300.0f64,
        fx in -20.0..20.0f64, fy in -20.0..20.0f64, fz in 5.0..200.0f64,
        down in any::<bool>(), couple in -500.0..500.0f64,
    ) {
        let at = Point2::new(x, y);
        let force = Vector3::new(fx, fy, if down { -fz } else { fz });
        let found = center_of_pressure(&wrench_at(at, force, couple), Z0_MM, 1.0).unwrap();
        prop_assert!((found.position_mm - at).norm() < EXACT_TOL_MM);
        // The free moment is a difference of moments up to 2e4 N·mm.
        prop_assert!((found.free_moment_nmm - couple).abs() < 1e-9);
    }

    #[test]
    fn lengths_in_another_unit_give_the_same_point(
        x in -300.0..300.0f64, y in -300.0..300.0f64, fz in 5.0..200.0f64,
    ) {
        let wrench = wrench_at(Point2::new(x, y), Vector3::new(1.0, 2.0, -fz), 30.0);
        let in_m = Wrench { torque_nmm: wrench.torque_nmm / 1000.0, ..wrench };
        let mm = center_of_pressure(&wrench, Z0_MM, 1.0).unwrap();
        let m = center_of_pressure(&in_m, Z0_MM / 1000.0, 1.0).unwrap();
        prop_assert!((mm.position_mm.coords / 1000.0 - m.position_mm.coords).norm() < EXACT_TOL_MM);
    }
}

#[test]
fn a_friction_couple_would_move_the_answer_if_mz_took_part() {
    let truth = Point2::new(20.0, -10.0);
    let wrench = wrench_at(truth, Vector3::new(1.5, 0.0, -40.0), 100.0);
    let (f, m) = (wrench.force_n, wrench.torque_nmm);
    // All three rows of M = p × F with z0 given, by least squares.
    let rows = DMatrix::from_row_slice(3, 2, &[0.0, f.z, -f.z, 0.0, f.y, -f.x]);
    let right = DVector::from_vec(vec![m.x + Z0_MM * f.y, m.y - Z0_MM * f.x, m.z]);
    let with_mz = rows.svd(true, true).solve(&right, 0.0).unwrap();
    let shift_mm = (with_mz[0] - truth.x).hypot(with_mz[1] - truth.y);
    assert!((shift_mm - 0.09).abs() < 0.01, "shift {shift_mm} mm");

    let found = center_of_pressure(&wrench, Z0_MM, 1.0).unwrap();
    assert!((found.position_mm - truth).norm() < EXACT_TOL_MM);
    assert!((found.free_moment_nmm - 100.0).abs() < 1e-10);
}

#[test]
fn a_light_touch_is_no_contact_on_either_side() {
    for fz in [0.0, 0.99, -0.99] {
        let wrench = wrench_at(Point2::origin(), Vector3::new(0.0, 0.0, fz), 0.0);
        let error = center_of_pressure(&wrench, Z0_MM, 1.0).unwrap_err();
        assert_eq!(error, FtCenterError::NoContact { fz_n: fz, min_fz_n: 1.0 });
    }
}

#[test]
fn numbers_that_are_none_are_errors() {
    let good = wrench_at(Point2::origin(), Vector3::new(0.0, 0.0, -40.0), 0.0);
    let mut bad = good;
    bad.torque_nmm.z = f64::NAN;
    assert!(matches!(center_of_pressure(&bad, Z0_MM, 1.0), Err(FtCenterError::NotFinite { .. })));
    assert!(matches!(
        center_of_pressure(&good, f64::INFINITY, 1.0),
        Err(FtCenterError::InvalidHeight { .. })
    ));
    for gate in [0.0, -1.0, f64::NAN] {
        assert!(matches!(
            center_of_pressure(&good, Z0_MM, gate),
            Err(FtCenterError::NotPositive { setting: "min_fz_n", .. })
        ));
    }
}
