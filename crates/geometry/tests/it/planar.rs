//! Planar maps: composition, inverse, polar parts, reflection.

use geometry::nalgebra::{Isometry2, Matrix2, Point2, SVD, Vector2};
use geometry::{GeometryError, PlanarMap};
use proptest::prelude::*;

use crate::seeded;

/// Round-off of a few products of coordinates up to 1e3 mm and ratios up to 10: mm.
const EXACT_TOL_MM: f64 = 1e4 * 16.0 * f64::EPSILON;

/// Round-off of ratios up to 10.
const RATIO_TOL: f64 = 10.0 * 16.0 * f64::EPSILON;

fn maps() -> impl Strategy<Value = PlanarMap> {
    (prop::array::uniform4(-5.0..5.0), prop::array::uniform2(-1e3..1e3)).prop_map(
        |([a, b, c, d], translation)| PlanarMap {
            linear: Matrix2::new(a, b, c, d),
            translation_mm: Vector2::from(translation),
        },
    )
}

proptest! {
    #![proptest_config(seeded(512))]

    #[test]
    fn parts_multiply_to_the_map(map in maps()) {
        let parts = map.parts();
        let whole = PlanarMap::rigid(parts.angle_rad, parts.reflected, Vector2::zeros()).linear
            * parts.stretch;
        prop_assert!((whole - map.linear).abs().max() < RATIO_TOL);
        prop_assert_eq!(parts.reflected, map.linear.determinant() < 0.0);
        prop_assert!(parts.stretch.symmetric_eigenvalues().min() > -RATIO_TOL);
        let svd = SVD::new(map.linear, false, false);
        prop_assert!((svd.singular_values[0] - parts.major_scale).abs() < RATIO_TOL);
        prop_assert!((svd.singular_values[1] - parts.minor_scale).abs() < RATIO_TOL);
    }

    #[test]
    fn inverse_undoes(map in maps(), x in -1e2..1e2, y in -1e2..1e2) {
        let parts = map.parts();
        prop_assume!(parts.minor_scale > 1e-3);
        let point = Point2::new(x, y);
        let back = map.inverse().unwrap().apply(&map.apply(&point));
        let condition = parts.major_scale / parts.minor_scale;
        prop_assert!((back - point).norm() < EXACT_TOL_MM * condition / parts.minor_scale);
    }

    #[test]
    fn products_apply_the_right_factor_first(a in maps(), b in maps(), x in -1e2..1e2) {
        let point = Point2::new(x, 1.0 - x);
        let error = ((a * b).apply(&point) - a.apply(&b.apply(&point))).norm();
        prop_assert!(error < EXACT_TOL_MM);
        let matrix = (a * b).to_homogeneous() - a.to_homogeneous() * b.to_homogeneous();
        prop_assert!(matrix.abs().max() < EXACT_TOL_MM);
    }

    #[test]
    fn rigid_maps_become_isometries_and_reflections_do_not(
        angle in -3.1..3.1, x in -1e3..1e3, y in -1e3..1e3,
    ) {
        let translation = Vector2::new(x, y);
        let expected = Isometry2::new(translation, angle);
        let proper = PlanarMap::rigid(angle, false, translation);
        let isometry = proper.to_isometry(RATIO_TOL).unwrap();
        prop_assert!((isometry.rotation.angle() - angle).abs() < RATIO_TOL);
        prop_assert!((PlanarMap::from(expected).linear - proper.linear).abs().max() < RATIO_TOL);

        let mirrored = PlanarMap::rigid(angle, true, translation);
        let parts = mirrored.parts();
        prop_assert!(parts.reflected);
        prop_assert!((parts.angle_rad - angle).abs() < RATIO_TOL);
        prop_assert!((parts.stretch - Matrix2::identity()).abs().max() < RATIO_TOL);
        let refused = mirrored.to_isometry(1.0);
        let said = matches!(refused, Err(GeometryError::NotRigid { determinant, .. })
            if determinant < 0.0);
        prop_assert!(said);
        // Mirrored twice about the same line is the identity.
        let twice = PlanarMap::rigid(angle, true, Vector2::zeros());
        let twice = (twice * twice).linear;
        prop_assert!((twice - Matrix2::identity()).abs().max() < RATIO_TOL);
    }
}

#[test]
fn a_proper_rotation_cannot_stand_in_for_a_reflection() {
    // A circle of 30 mm seen by a sensor whose z opposes the machine's: the best rotation misses.
    let mirrored = PlanarMap::rigid(0.3, true, Vector2::zeros());
    let n_points = 360;
    let mut least_rms = f64::INFINITY;
    for step in 0..3600 {
        let candidate =
            PlanarMap::rigid(f64::from(step).to_radians() / 10.0, false, Vector2::zeros());
        let square: f64 = (0..n_points)
            .map(|i| {
                let (sin, cos) = f64::from(i).to_radians().sin_cos();
                let point = Point2::new(30.0 * cos, 30.0 * sin);
                (mirrored.apply(&point) - candidate.apply(&point)).norm_squared()
            })
            .sum();
        least_rms = least_rms.min((square / f64::from(n_points)).sqrt());
    }
    // √2 · 30 mm: every rotation is as far from a reflection as the identity is.
    assert!((least_rms - 30.0 * 2.0_f64.sqrt()).abs() < 1e-9, "{least_rms}");
}

#[test]
fn a_flattened_plane_has_no_inverse() {
    for linear in [
        Matrix2::zeros(),
        Matrix2::new(1.0, 2.0, 2.0, 4.0),
        Matrix2::new(0.1, 0.3, 0.3, 0.9),
        Matrix2::new(1e-300, 0.0, 0.0, 0.0),
    ] {
        let map = PlanarMap { linear, translation_mm: Vector2::zeros() };
        assert!(matches!(map.inverse(), Err(GeometryError::Singular { .. })), "{linear}");
    }
    let broken = PlanarMap { linear: Matrix2::identity() * f64::NAN, ..PlanarMap::identity() };
    assert!(matches!(broken.inverse(), Err(GeometryError::NonFinite { .. })));
    assert!(matches!(broken.to_isometry(1.0), Err(GeometryError::NotRigid { .. })));
}
