//! Gradients, normals and curvatures against differences.

use geometry::nalgebra::{Point3, Unit, Vector3};
use geometry::{Asphere, AsphereShape, Plane, Sphere, Surface};

use crate::aspheres::{aspheres, random_point, reach_mm, rim_mm, sag_mm};
use crate::regimes::rng;

/// Difference step as a share of the reach.
const STEP_RATIO: f64 = 3e-4;

/// Slopes by differences, worst at 0.9 of a near-hemisphere's rim: truncation h⁴ z⁗′/30 = 3e-11.
const SLOPE_TOL: f64 = 1e-10;

/// The same for the turning of the normal, per mm.
const TURN_TOL_PER_MM: f64 = 1e-10;

fn derivative(f: impl Fn(f64) -> f64, h: f64) -> f64 {
    (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
}

/// Points with room for differences, and not where a near-hemisphere turns upright.
fn inner_points(asphere: &Asphere, seed: u64) -> Vec<Point3<f64>> {
    let mut rng = rng(seed);
    let limit = 0.9 * rim_mm(asphere.shape());
    let mut points: Vec<_> = (0..100).map(|_| random_point(asphere.shape(), &mut rng)).collect();
    points.retain(|p| p.x.hypot(p.y) < limit);
    points
}

#[test]
fn sag_follows_the_standard() {
    for asphere in aspheres() {
        for point in inner_points(&asphere, 51) {
            let error = asphere.sag_mm(point.x, point.y).unwrap() - point.z;
            assert!(error.abs() < 1e-14 * reach_mm(asphere.shape()), "{error}");
        }
    }
    // Vertex of the bowl of document [D]: z = r²/2R for a paraboloid.
    let bowl = Asphere::new(AsphereShape::on_axis(480.0, -1.0, vec![], 100.0)).unwrap();
    assert!((bowl.sag_mm(30.0, 40.0).unwrap() - 2500.0 / 960.0).abs() < 1e-15);
    // R > 0 opens to +z, R < 0 to −z; A4 and A6 are the first two coefficients.
    let dome = Asphere::new(AsphereShape::on_axis(-480.0, -1.0, vec![1e-6, 1e-9], 100.0)).unwrap();
    let expected = -100.0 / 960.0 + 1e-6 * 1e4 + 1e-9 * 1e6;
    assert!((dome.sag_mm(10.0, 0.0).unwrap() - expected).abs() < 1e-15);
}

#[test]
fn gradient_and_normal() {
    for asphere in aspheres() {
        let h = STEP_RATIO * reach_mm(asphere.shape());
        for p in inner_points(&asphere, 52) {
            let gradient = asphere.gradient(p.x, p.y).unwrap();
            let sag = |x: f64, y: f64| sag_mm(asphere.shape(), x.hypot(y));
            let by_x = derivative(|d| sag(p.x + d, p.y), h);
            let by_y = derivative(|d| sag(p.x, p.y + d), h);
            assert!((gradient.x - by_x).abs() < SLOPE_TOL, "{:?} {p}", asphere.shape());
            assert!((gradient.y - by_y).abs() < SLOPE_TOL, "{:?} {p}", asphere.shape());
            let expected = Vector3::new(-gradient.x, -gradient.y, 1.0).normalize();
            let normal = asphere.normal(p.x, p.y).unwrap();
            assert!((normal.into_inner() - expected).norm() < 4.0 * f64::EPSILON);
        }
    }
}

/// `−dn/ds = κ t` along a principal direction (Rodrigues).
fn assert_principal(
    normal_at: impl Fn(Point3<f64>) -> Unit<Vector3<f64>>,
    point: Point3<f64>,
    direction: &Unit<Vector3<f64>>,
    curvature: f64,
    h: f64,
) {
    let turn = Vector3::from_fn(|i, _| {
        derivative(|d| normal_at(point + direction.into_inner() * d)[i], h)
    });
    let error = (turn + direction.into_inner() * curvature).norm();
    assert!(error < TURN_TOL_PER_MM, "{point}: {error} per mm");
}

#[test]
fn principal_curvatures_turn_the_normal() {
    for asphere in aspheres() {
        let h = STEP_RATIO * reach_mm(asphere.shape());
        for p in inner_points(&asphere, 53) {
            let k = asphere.curvature(&p).unwrap();
            assert!(k.major_per_mm >= k.minor_per_mm);
            let normal = asphere.normal(p.x, p.y).unwrap();
            assert!(k.major_direction.dot(&k.minor_direction).abs() < 4.0 * f64::EPSILON);
            assert!(k.major_direction.dot(&normal).abs() < 4.0 * f64::EPSILON);
            assert!(k.minor_direction.dot(&normal).abs() < 4.0 * f64::EPSILON);
            // The chord leaves the surface by κh²/2, in which the normal along z does not change
            // to first order.
            let normal_at = |q: Point3<f64>| asphere.normal(q.x, q.y).unwrap();
            assert_principal(normal_at, p, &k.major_direction, k.major_per_mm, h);
            assert_principal(normal_at, p, &k.minor_direction, k.minor_per_mm, h);
        }
    }
}

#[test]
fn vertex_curvature_is_the_inverse_radius() {
    for asphere in aspheres() {
        let k = asphere.curvature(&Point3::origin()).unwrap();
        let expected = 1.0 / asphere.shape().radius_mm;
        assert!((k.major_per_mm - expected).abs() <= f64::EPSILON * expected.abs());
        assert!((k.minor_per_mm - expected).abs() <= f64::EPSILON * expected.abs());
        assert!((k.mean_per_mm() - expected).abs() <= f64::EPSILON * expected.abs());
    }
}

#[test]
fn plane_and_sphere_are_umbilic() {
    let plane = Plane::new(Point3::origin(), Vector3::new(1.0, 2.0, -2.0)).unwrap();
    let flat = plane.curvature(&Point3::new(5.0, 5.0, 5.0)).unwrap();
    assert!(flat.major_per_mm == 0.0 && flat.minor_per_mm == 0.0);
    assert!(flat.major_direction.dot(&plane.normal()).abs() < 4.0 * f64::EPSILON);

    let center = Point3::new(1.0, -2.0, 3.0);
    let sphere = Sphere::new(center, 8.0).unwrap();
    let outwards = Vector3::new(3.0, 1.0, -2.0).normalize();
    let p = center + outwards * 8.0;
    let k = sphere.curvature(&p).unwrap();
    assert!((k.gaussian_per_mm2() - 1.0 / 64.0).abs() < f64::EPSILON);
    let normal_at = |q: Point3<f64>| Unit::new_normalize(q - center);
    assert_principal(normal_at, p, &k.major_direction, k.major_per_mm, 8e-3);
    assert_principal(normal_at, p, &k.minor_direction, k.minor_per_mm, 8e-3);
}
