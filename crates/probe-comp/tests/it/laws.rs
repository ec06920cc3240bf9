//! What holds for every sphere and every place on it.

use std::sync::Arc;

use geometry::Sphere;
use nalgebra::{Isometry3, Point3, Vector3};
use probe_comp::{BallTouch, Nominal, NormalSource, Side, compensate};
use proptest::prelude::*;

/// Coordinates of a metre, through a dozen operations.
const EXACT_MM: f64 = 1e-11;

fn vector(half: f64) -> impl Strategy<Value = Vector3<f64>> {
    [-half..half, -half..half, -half..half].prop_map(Vector3::from)
}

fn direction() -> impl Strategy<Value = Vector3<f64>> {
    vector(1.0)
        .prop_filter("long enough for a direction", |v| v.norm() > 0.1)
        .prop_map(|v| v.normalize())
}

fn sphere(center_mm: Vector3<f64>, radius_mm: f64, side: Side) -> Nominal {
    Nominal::new(Arc::new(Sphere::new(Point3::from(center_mm), radius_mm).unwrap()), side)
}

proptest! {
    /// A ball that stands off a sphere by its own radius and a deviation more touches it on the line
    /// through both centres, and deviates by that much; inside as outside.
    #[test]
    fn the_deviation_is_what_the_ball_stands_off(
        center_mm in vector(500.0),
        radius_mm in 10.0..400.0,
        towards in direction(),
        tip_mm in 0.0..5.0,
        deviation_mm in -0.1..0.1_f64,
        is_inside in any::<bool>(),
    ) {
        let (side, sign) = if is_inside { (Side::Against, -1.0) } else { (Side::Along, 1.0) };
        let normal = towards * sign;
        let on = center_mm + towards * radius_mm;
        let touch = BallTouch::new(Point3::from(on + normal * (tip_mm + deviation_mm)), 1e-3);
        let nominal = sphere(center_mm, radius_mm, side);
        let contacts = compensate(&nominal, tip_mm, &[touch], NormalSource::Nominal).unwrap();
        prop_assert!((contacts[0].deviation_mm - deviation_mm).abs() < EXACT_MM);
        prop_assert!((contacts[0].normal.into_inner() - normal).norm() < EXACT_MM);
        let off_mm = contacts[0].point_mm.coords - (on + normal * deviation_mm);
        prop_assert!(off_mm.norm() < EXACT_MM, "{off_mm}");
    }

    /// Part and touches moved together deviate as before, at the moved places.
    #[test]
    fn a_part_that_is_moved_deviates_alike(
        center_mm in vector(200.0),
        radius_mm in 20.0..200.0,
        towards in direction(),
        off_mm in 0.9..1.1,
        shift_mm in vector(300.0),
        turn_rad in vector(1.8),
    ) {
        let motion = Isometry3::new(shift_mm, turn_rad);
        let at = Point3::from(center_mm + towards * (radius_mm + off_mm));
        let one = |center_mm: Vector3<f64>, at: Point3<f64>| {
            let nominal = sphere(center_mm, radius_mm, Side::Along);
            compensate(&nominal, 1.0, &[BallTouch::new(at, 1e-3)], NormalSource::Nominal).unwrap().remove(0)
        };
        let still = one(center_mm, at);
        let moved = one((motion * Point3::from(center_mm)).coords, motion * at);
        prop_assert!((still.deviation_mm - moved.deviation_mm).abs() < EXACT_MM);
        prop_assert!((motion * still.point_mm - moved.point_mm).norm() < EXACT_MM);
    }
}
