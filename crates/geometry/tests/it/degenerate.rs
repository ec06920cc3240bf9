//! Input that has no answer gets a typed error, and nothing panics or hangs.

use geometry::nalgebra::{Point2, Point3, Unit, Vector3};
use geometry::{Asphere, AsphereShape, GeometryError, Line, Plane, Sphere, Surface};
use proptest::prelude::*;

use crate::aspheres::aspheres;
use crate::seeded;

fn bowl() -> AsphereShape {
    AsphereShape::on_axis(480.0, -1.0, vec![], 100.0)
}

fn refusal(shape: AsphereShape) -> GeometryError {
    Asphere::new(shape).expect_err("no usable shape")
}

#[test]
fn shapes_that_are_none() {
    use GeometryError::{ApertureBeyondConic, InvalidAperture, InvalidRadius, NonFinite};
    for radius_mm in [0.0, -0.0] {
        let shape = AsphereShape { radius_mm, ..bowl() };
        assert!(matches!(refusal(shape), InvalidRadius { .. }));
    }
    for radius_mm in [f64::NAN, 1e-310] {
        let shape = AsphereShape { radius_mm, ..bowl() };
        assert!(matches!(refusal(shape), NonFinite { .. }), "{radius_mm}");
    }
    for diameter_mm in [0.0, -1.0] {
        let shape = AsphereShape { diameter_mm, ..bowl() };
        assert!(matches!(refusal(shape), InvalidAperture { .. }));
    }
    for broken in [f64::NAN, f64::INFINITY, 1e300] {
        let center = Point2::new(broken, 0.0);
        for shape in [
            AsphereShape { coefficients: vec![0.0, broken], ..bowl() },
            AsphereShape { diameter_mm: broken, ..bowl() },
            AsphereShape { aperture_center_mm: center, ..bowl() },
        ] {
            let said = refusal(shape.clone());
            assert!(matches!(said, NonFinite { .. }), "{shape:?}: {said:?}");
        }
    }
    for conic in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(matches!(refusal(AsphereShape { conic, ..bowl() }), NonFinite { .. }));
    }
    // A sphere of radius 25 ends at a diameter of 50.
    for diameter in [50.0, 60.0] {
        let said = refusal(AsphereShape::on_axis(25.0, 0.0, vec![], diameter));
        assert!(matches!(said, ApertureBeyondConic { limit_mm, .. }
            if (limit_mm - 25.0).abs() < 1e-13));
    }
    let off_axis = AsphereShape {
        aperture_center_mm: Point2::new(15.0, 0.0),
        ..AsphereShape::on_axis(25.0, 0.0, vec![], 30.0)
    };
    assert!(matches!(refusal(off_axis), ApertureBeyondConic { .. }));
}

#[test]
fn beyond_the_end_of_the_conic() {
    let asphere = Asphere::new(AsphereShape::on_axis(25.0, 0.0, vec![], 40.0)).unwrap();
    assert!(asphere.sag_mm(24.9, 0.0).is_ok());
    assert!((asphere.sag_mm(25.0, 0.0).unwrap() - 25.0).abs() < 1e-12);
    let undefined = |result: Result<(), GeometryError>| {
        assert!(matches!(result, Err(GeometryError::SagUndefined { .. })), "{result:?}");
    };
    undefined(asphere.sag_mm(25.1, 0.0).map(drop));
    undefined(asphere.gradient(25.0, 0.0).map(drop));
    undefined(asphere.normal(20.0, 20.0).map(drop));
    undefined(asphere.curvature(&Point3::new(0.0, -26.0, 0.0)).map(drop));
}

#[test]
fn centres_of_curvature() {
    let sphere = Sphere::new(Point3::new(1.0, 2.0, 3.0), 10.0).unwrap();
    let ambiguous = |result: Result<_, GeometryError>| {
        assert!(matches!(result, Err(GeometryError::AmbiguousFoot { .. })), "{result:?}");
    };
    ambiguous(sphere.closest_point(&sphere.center_mm()).map(drop));
    ambiguous(sphere.curvature(&sphere.center_mm()).map(drop));
    // The same sphere as an asphere: every point of the cap is equally far.
    for radius in [25.0, -25.0] {
        let cap = Asphere::new(AsphereShape::on_axis(radius, 0.0, vec![], 40.0)).unwrap();
        ambiguous(cap.closest_point(&Point3::new(0.0, 0.0, radius)).map(drop));
        ambiguous(cap.closest_point(&Point3::new(1e-9, 0.0, radius)).map(drop));
    }
    let bowl = Asphere::new(bowl()).unwrap();
    ambiguous(bowl.closest_point(&Point3::new(0.0, 0.0, 480.0)).map(drop));
}

#[test]
fn directions_without_length() {
    let zero = Vector3::zeros();
    let plane = Plane::new(Point3::origin(), zero);
    assert!(matches!(plane, Err(GeometryError::NoDirection { .. })));
    let line = Line::new(Point3::origin(), zero);
    assert!(matches!(line, Err(GeometryError::NoDirection { .. })));
    // Any length other than zero gives a direction, however long or short.
    for length in [1e-300, f64::MIN_POSITIVE, 1e300] {
        let line = Line::new(Point3::origin(), Vector3::new(length, 0.0, length)).unwrap();
        assert!((line.direction.x - 0.5_f64.sqrt()).abs() < f64::EPSILON);
    }
    for radius in [0.0, -1.0] {
        let sphere = Sphere::new(Point3::origin(), radius);
        assert!(matches!(sphere, Err(GeometryError::InvalidRadius { .. })));
    }
}

#[test]
fn broken_queries() {
    let sphere = Sphere::new(Point3::origin(), 10.0).unwrap();
    let plane = Plane::new(Point3::origin(), Vector3::z()).unwrap();
    let aspheres = aspheres();
    let surfaces: Vec<&dyn Surface> =
        aspheres.iter().map(|a| a as &dyn Surface).chain([&sphere as _, &plane as _]).collect();
    for surface in surfaces {
        for broken in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for axis in 0..3 {
                let point = Point3::from(Vector3::ith(axis, broken));
                let refused = surface.closest_point(&point);
                assert!(matches!(refused, Err(GeometryError::NonFinite { .. })), "{surface:?}");
                let line = Line { point_mm: point, direction: Vector3::x_axis() };
                assert!(surface.hits(&line).is_err());
                assert!(surface.first_hit(&line).is_err());
            }
        }
        for broken in [Vector3::zeros(), Vector3::x() * f64::NAN] {
            let direction = Unit::new_unchecked(broken);
            let line = Line { point_mm: Point3::new(0.1, 0.2, 50.0), direction };
            assert!(surface.hits(&line).is_err(), "{surface:?}");
        }
    }
}

fn wild() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -1e3..1e3,
        1 => prop::num::f64::ANY,
        1 => prop::sample::select(vec![0.0, 1e-300, 1e-9, 1e5, 1e12, 1e300, -1.0, -1e-12]),
    ]
}

proptest! {
    #![proptest_config(seeded(4096))]

    /// Whatever the numbers, an answer is either on the surface or a typed error.
    #[test]
    fn nothing_panics_and_answers_are_finite(
        radius_mm in wild(), conic in wild(), a4 in wild(), a6 in wild(), diameter_mm in wild(),
        x in wild(), y in wild(), z in wild(), direction in prop::array::uniform3(-1.0..1.0),
    ) {
        let shape = AsphereShape {
            radius_mm,
            conic,
            coefficients: vec![a4 * 1e-7, a6 * 1e-10],
            diameter_mm,
            aperture_center_mm: Point2::origin(),
        };
        let Ok(asphere) = Asphere::new(shape) else { return Ok(()) };
        let query = Point3::new(x, y, z);
        if let Ok(foot) = asphere.closest_point(&query) {
            prop_assert!(foot.point_mm.iter().all(|v| v.is_finite()));
            prop_assert!(foot.signed_distance_mm.is_finite());
            prop_assert!((foot.normal.norm() - 1.0).abs() < 1e-14);
            let arm = query - foot.point_mm;
            let size = arm.norm() + query.coords.norm();
            let off = arm.cross(&foot.normal).norm();
            prop_assert!(off <= 1e-12 * size / foot.normal.z.powi(2), "{off}");
        }
        if let Ok(line) = Line::new(query, Vector3::from(direction)) {
            for hit in asphere.hits(&line).unwrap_or_default() {
                prop_assert!(hit.point_mm.iter().all(|v| v.is_finite()));
            }
            let _ = asphere.first_hit(&line);
        }
    }
}
