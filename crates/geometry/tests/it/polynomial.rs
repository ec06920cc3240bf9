//! The polynomial surface against surfaces known otherwise.

use geometry::nalgebra::{Point3, Vector3};
use geometry::{Asphere, AsphereShape, GeometryError, Line, Polynomial, Surface};
use proptest::prelude::*;

use crate::seeded;

const RADIUS_MM: f64 = 480.0;
/// Coordinates of 100 mm, some hundred operations.
const EXACT_TOL_MM: f64 = 1e-11;

/// `r²/2R` in units of 100 mm.
fn paraboloid() -> Polynomial {
    let a = 1e4 / (2.0 * RADIUS_MM);
    Polynomial::new(100.0, [(2, 0, a), (0, 2, a)]).expect("a sound surface")
}

fn asphere() -> Asphere {
    Asphere::new(AsphereShape::on_axis(RADIUS_MM, -1.0, vec![], 200.0)).expect("a sound surface")
}

proptest! {
    #![proptest_config(seeded(256))]

    #[test]
    fn a_paraboloid_is_the_same_as_an_asphere_of_conic_minus_one(
        x in -60.0..60.0_f64, y in -60.0..60.0_f64, z in -100.0..100.0_f64,
    ) {
        let query = Point3::new(x, y, z);
        let (a, b) = (paraboloid().closest_point(&query).unwrap(), asphere().closest_point(&query).unwrap());
        prop_assert!((a.point_mm - b.point_mm).norm() < EXACT_TOL_MM);
        prop_assert!((a.signed_distance_mm - b.signed_distance_mm).abs() < EXACT_TOL_MM);
        let (a, b) = (paraboloid().curvature(&query).unwrap(), asphere().curvature(&query).unwrap());
        prop_assert!((a.major_per_mm - b.major_per_mm).abs() < 1e-14);
        prop_assert!((a.minor_per_mm - b.minor_per_mm).abs() < 1e-14);
    }

    #[test]
    fn a_foot_is_the_base_of_a_perpendicular(
        x in -300.0..300.0_f64, y in -300.0..300.0_f64, d in -20.0..20.0_f64,
    ) {
        let surface = freeform();
        let on = Point3::new(x, y, surface.sag_mm(x, y));
        let slope = surface.gradient(x, y);
        let normal = Vector3::new(-slope.x, -slope.y, 1.0).normalize();
        let foot = surface.closest_point(&(on + normal * d)).unwrap();
        prop_assert!((foot.point_mm - on).norm() < 1e-9, "{}", (foot.point_mm - on).norm());
        prop_assert!((foot.signed_distance_mm - d).abs() < 1e-9);
    }

    #[test]
    fn a_line_through_two_points_of_the_surface_hits_both(
        ax in -300.0..300.0_f64, ay in -300.0..300.0_f64,
        bx in -300.0..300.0_f64, by in -300.0..300.0_f64,
    ) {
        prop_assume!((ax - bx).hypot(ay - by) > 10.0);
        let surface = freeform();
        let at = |x: f64, y: f64| Point3::new(x, y, surface.sag_mm(x, y));
        let (a, b) = (at(ax, ay), at(bx, by));
        let line = Line::new(a, b - a).unwrap();
        let hits = surface.hits(&line).unwrap();
        for point in [a, b] {
            let near = hits.iter().map(|h| (h.point_mm - point).norm()).fold(f64::MAX, f64::min);
            prop_assert!(near < 1e-6, "{near:e} of {} hits", hits.len());
        }
        for hit in &hits {
            let off = (hit.point_mm.z - surface.sag_mm(hit.point_mm.x, hit.point_mm.y)).abs();
            prop_assert!(off < 1e-9 * (1.0 + hit.point_mm.coords.amax()), "{off:e}");
        }
        prop_assert!(hits.windows(2).all(|w| w[0].distance_mm < w[1].distance_mm));
    }
}

/// A freeform of several metres of radius with a wave on it.
fn freeform() -> Polynomial {
    Polynomial::new(
        3000.0,
        [
            (2, 0, 700.0),
            (0, 2, 900.0),
            (1, 1, -150.0),
            (3, 0, 400.0),
            (2, 2, -3000.0),
            (0, 4, 5000.0),
        ],
    )
    .expect("a sound surface")
}

#[test]
fn curvature_agrees_with_differences_of_the_normal() {
    let surface = freeform();
    let at = Point3::new(210.0, -140.0, surface.sag_mm(210.0, -140.0));
    let curvature = surface.curvature(&at).unwrap();
    for (per_mm, direction) in [
        (curvature.major_per_mm, curvature.major_direction),
        (curvature.minor_per_mm, curvature.minor_direction),
    ] {
        let step = 1e-2;
        let normal =
            |t: f64| surface.closest_point(&(at + direction.into_inner() * t)).unwrap().normal;
        let turned = (normal(step).into_inner() - normal(-step).into_inner()) / (2.0 * step);
        // The normal of a bowl turns against the direction of travel; second differences of 1e-2.
        assert!((turned.dot(&direction) + per_mm).abs() < 1e-8, "{}", turned.dot(&direction));
    }
}

#[test]
fn what_makes_no_surface_or_no_answer() {
    assert!(matches!(Polynomial::new(0.0, []), Err(GeometryError::InvalidRadius { .. })));
    assert!(matches!(Polynomial::new(f64::NAN, []), Err(GeometryError::NonFinite { .. })));
    assert!(matches!(
        Polynomial::new(1.0, [(usize::MAX, 3, 1.0)]),
        Err(GeometryError::DegreeTooHigh { .. })
    ));
    assert!(matches!(
        Polynomial::new(1.0, [(1, 0, f64::INFINITY)]),
        Err(GeometryError::NonFinite { .. })
    ));
    let flat = Polynomial::new(1.0, [(0, 0, 2.0)]).unwrap();
    let along = Line::new(Point3::new(0.0, 0.0, 2.0), Vector3::x()).unwrap();
    assert_eq!(flat.hits(&along), Err(GeometryError::LineInSurface));
    let beside = Line::new(Point3::new(0.0, 0.0, 3.0), Vector3::x()).unwrap();
    assert_eq!(flat.hits(&beside), Err(GeometryError::Misses));
    let away = Line::new(Point3::new(0.0, 0.0, 3.0), Vector3::z()).unwrap();
    assert!(matches!(flat.first_hit(&away), Err(GeometryError::BehindRay { .. })));
    // The centre of curvature of a bowl has no single foot.
    let center = Point3::new(0.0, 0.0, RADIUS_MM);
    assert!(matches!(
        paraboloid().closest_point(&center),
        Err(GeometryError::AmbiguousFoot { .. })
    ));
}
