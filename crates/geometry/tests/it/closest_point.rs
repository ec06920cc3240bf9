//! Closest points: on the surface, square to it, and not beaten by a scan of the whole surface.

use geometry::nalgebra::{Point3, Vector3};
use geometry::{Asphere, AsphereShape, Foot, GeometryError, Plane, Sphere, Surface};
use rand::RngExt;

use crate::aspheres::{aspheres, max_curvature_per_mm, random_point, reach_mm, sag_mm};
use crate::regimes::{rng, vector};

/// Demanded of feet of points measured near a part of some 100 mm.
const FOOT_TOL_MM: f64 = 1e-12;

/// Steps of the scan of a meridian.
const SCAN_STEPS: u32 = 4000;

/// Distance to the surface and radius of the foot by scanning the meridian and refining the best
/// step by golden section, which resolves the distance to round-off but the foot only to √ε.
fn scanned(shape: &AsphereShape, query: &Point3<f64>) -> (f64, f64) {
    let radius = query.x.hypot(query.y);
    let reach = reach_mm(shape);
    let distance = |r: f64| (r - radius).hypot(sag_mm(shape, r) - query.z);
    let step = reach / f64::from(SCAN_STEPS);
    let best = (0..=SCAN_STEPS)
        .map(|i| f64::from(i) * step)
        .min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
        .expect("steps to scan");
    let (mut lo, mut hi) = ((best - step).max(0.0), (best + step).min(reach));
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    for _ in 0..60 {
        let (a, b) = (hi - golden * (hi - lo), lo + golden * (hi - lo));
        if distance(a) < distance(b) { hi = b } else { lo = a }
    }
    let r = 0.5 * (lo + hi);
    (distance(r), r)
}

fn assert_foot(shape: &AsphereShape, query: &Point3<f64>, foot: &Foot) {
    let size = reach_mm(shape) + query.coords.norm();
    // A few roundings of the coordinates; the sag's own error is magnified by a steep slope.
    let steepness = 1.0 / foot.normal.z;
    let tolerance = 16.0 * f64::EPSILON * size * steepness;
    let p = foot.point_mm;
    assert!((p.z - sag_mm(shape, p.x.hypot(p.y))).abs() < tolerance, "off the surface: {query}");
    let arm = query - p;
    let square = arm.cross(&foot.normal).norm();
    assert!(square < tolerance * (1.0 + arm.norm() / size), "not square: {query} {square}");
    assert!((arm.dot(&foot.normal) - foot.signed_distance_mm).abs() < tolerance);
    assert!((foot.normal.norm() - 1.0).abs() < 4.0 * f64::EPSILON && foot.normal.z > 0.0);
}

#[test]
fn no_point_of_the_surface_is_closer() {
    let mut rng = rng(41);
    let mut n_refused = [0, 0];
    let n_queries = 400;
    for asphere in aspheres() {
        let shape = asphere.shape();
        let far = (3.0 / max_curvature_per_mm(shape)).min(10.0 * reach_mm(shape));
        for i in 0..n_queries {
            // Near the surface, at some distance, and far past its centres of curvature.
            let away = [1e-3, 0.1, 1.0][i % 3] * far;
            let query = random_point(shape, &mut rng) + vector(&mut rng, away);
            let (distance, r) = scanned(shape, &query);
            match asphere.closest_point(&query) {
                Ok(foot) => {
                    assert_foot(shape, &query, &foot);
                    let excess = foot.signed_distance_mm.abs() - distance;
                    assert!(excess < 1e-11, "{shape:?} {query}: {excess} mm farther");
                }
                Err(GeometryError::OutsideAperture { .. }) => {
                    let step = reach_mm(shape) / f64::from(SCAN_STEPS);
                    assert!(r > reach_mm(shape) - step, "{shape:?} {query}: foot at {r}");
                    n_refused[0] += 1;
                }
                Err(GeometryError::AmbiguousFoot { distance_mm }) => {
                    assert!((distance_mm - distance).abs() < 1e-6 * distance);
                    n_refused[1] += 1;
                }
                Err(other) => panic!("{shape:?} {query}: {other}"),
            }
        }
    }
    // Random queries do not fall on the medial axis.
    assert!(n_refused[0] > 0 && n_refused[1] == 0, "{n_refused:?}");
}

#[test]
fn points_pushed_off_along_the_normal_come_back() {
    let mut rng = rng(42);
    for asphere in aspheres() {
        let shape = asphere.shape();
        for _ in 0..500 {
            let on = random_point(shape, &mut rng);
            let normal = asphere.normal(on.x, on.y).unwrap();
            let curvature = asphere.curvature(&on).unwrap();
            let distance = rng.random_range(-5.0..5.0);
            let stiffness = [curvature.major_per_mm, curvature.minor_per_mm]
                .map(|k| 1.0 - distance * k)
                .into_iter()
                .fold(1.0, f64::min);
            let query = on + normal.into_inner() * distance;
            let foot = asphere.closest_point(&query).unwrap();
            assert!(foot.inside_aperture || (foot.point_mm - on).norm() < FOOT_TOL_MM);
            let steepness = 1.0 / normal.z;
            let error = (foot.point_mm - on).norm();
            assert!(error < FOOT_TOL_MM * steepness / stiffness, "{shape:?} {on}: {error}");
            assert!((foot.signed_distance_mm - distance).abs() < FOOT_TOL_MM, "{shape:?} {on}");
        }
    }
}

#[test]
fn sphere_shaped_aspheres_agree_with_the_sphere() {
    let mut rng = rng(43);
    for radius in [50.0, -50.0_f64] {
        let asphere = Asphere::new(AsphereShape::on_axis(radius, 0.0, vec![], 60.0)).unwrap();
        let sphere = Sphere::new(Point3::new(0.0, 0.0, radius), radius.abs()).unwrap();
        for _ in 0..500 {
            let query = random_point(asphere.shape(), &mut rng) + vector(&mut rng, 20.0);
            let Ok(foot) = asphere.closest_point(&query) else { continue };
            let expected = sphere.closest_point(&query).unwrap();
            assert!((foot.point_mm - expected.point_mm).norm() < 10.0 * FOOT_TOL_MM, "{query}");
            // The bowl's normal points to the centre, the sphere's away from it.
            let flipped = -radius.signum() * expected.signed_distance_mm;
            assert!((foot.signed_distance_mm - flipped).abs() < FOOT_TOL_MM, "{query}");
        }
    }
}

#[test]
fn queries_on_the_axis_have_the_vertex_as_foot_below_the_centre_of_curvature() {
    for (asphere, z) in aspheres().iter().zip([400.0, 40.0, -70.0, 10.0, -18.0, 900.0, 15.0, 20.0])
    {
        for query in [Point3::new(0.0, 0.0, z), Point3::new(0.0, 0.0, -0.1 * z)] {
            let foot = asphere.closest_point(&query).unwrap();
            assert_eq!(foot.point_mm, Point3::origin(), "{query}");
            assert_eq!(foot.normal.into_inner(), Vector3::z());
            assert!((foot.signed_distance_mm - query.z).abs() <= f64::EPSILON * query.z.abs());
        }
    }
}

#[test]
fn a_ring_of_feet_is_refused_and_its_neighbours_are_not() {
    // Paraboloid z = r²/2R: beyond the centre of curvature the axis has a ring of feet,
    // r² = 2R(z − R), at the same distance.
    let asphere = Asphere::new(AsphereShape::on_axis(40.0, -1.0, vec![], 60.0)).unwrap();
    for z in [40.0, 41.0, 45.0] {
        let refused = asphere.closest_point(&Point3::new(0.0, 0.0, z));
        assert!(matches!(refused, Err(GeometryError::AmbiguousFoot { .. })), "{z}: {refused:?}");
    }
    let beside = asphere.closest_point(&Point3::new(1e-3, 0.0, 45.0)).unwrap();
    let ring = (2.0 * 40.0 * (45.0 - 40.0_f64)).sqrt();
    assert!((beside.point_mm.x - ring).abs() < 1e-2 && beside.point_mm.y == 0.0);
}

/// `z = −a (r² − b²)² + a b⁴`, a gull wing with its crest at r = 15 mm; in the form of the standard
/// the r² term is a paraboloid.
fn gull_wing() -> Asphere {
    let (a, b) = (2e-4_f64, 15.0_f64);
    let radius = 1.0 / (4.0 * a * b * b);
    Asphere::new(AsphereShape::on_axis(radius, -1.0, vec![-a], 50.0)).expect("valid shape")
}

#[test]
fn the_nearer_of_two_feet_is_found_on_a_gull_wing() {
    // Queries under the wing see both flanks.
    let asphere = gull_wing();
    let mut rng = rng(44);
    for _ in 0..300 {
        let query = Point3::new(rng.random_range(-20.0..20.0), 0.0, rng.random_range(-60.0..60.0));
        let (distance, r) = scanned(asphere.shape(), &query);
        match asphere.closest_point(&query) {
            Ok(foot) => assert!((foot.signed_distance_mm.abs() - distance).abs() < 1e-11),
            Err(GeometryError::OutsideAperture { .. }) => assert!(r > 31.0, "{query} {r}"),
            Err(other) => panic!("{query}: {other}"),
        }
    }
}

#[test]
fn halfway_between_two_flanks_is_refused() {
    let asphere = gull_wing();
    let foot = |x: f64| asphere.closest_point(&Point3::new(x, 0.0, -8.0));
    let (mut inner, mut outer) = (10.0, 20.0);
    assert!(foot(inner).unwrap().point_mm.x < 15.0 && foot(outer).unwrap().point_mm.x > 15.0);
    let tie = (0..60).find_map(|_| {
        let middle = 0.5 * (inner + outer);
        match foot(middle) {
            Ok(foot) if foot.point_mm.x < 15.0 => inner = middle,
            Ok(_) => outer = middle,
            Err(error) => return Some(error),
        }
        None
    });
    let refused = matches!(tie, Some(GeometryError::AmbiguousFoot { .. }));
    assert!(refused, "{tie:?} between {inner} and {outer}");
}

#[test]
fn feet_past_the_rim_are_marked() {
    let asphere = Asphere::new(AsphereShape::on_axis(480.0, -1.0, vec![], 100.0)).unwrap();
    let over = |x| asphere.closest_point(&Point3::new(x, 0.0, 5.0));
    assert!(over(49.0).unwrap().inside_aperture);
    assert!(!over(55.0).unwrap().inside_aperture);
    assert!(matches!(over(80.0), Err(GeometryError::OutsideAperture { .. })));
}

#[test]
fn plane_and_sphere() {
    let mut rng = rng(45);
    for _ in 0..500 {
        let (at, query) = (Point3::from(vector(&mut rng, 100.0)), vector(&mut rng, 300.0).into());
        let normal = vector(&mut rng, 1.0);
        let plane = Plane::new(at, normal).unwrap();
        let foot = plane.closest_point(&query).unwrap();
        assert!((foot.point_mm - at).dot(&plane.normal()).abs() < FOOT_TOL_MM);
        assert!((query - foot.point_mm).cross(&plane.normal()).norm() < FOOT_TOL_MM);
        let above = plane.closest_point(&(at + normal)).unwrap();
        assert!((above.signed_distance_mm - normal.norm()).abs() < FOOT_TOL_MM);

        let sphere = Sphere::new(at, rng.random_range(1.0..100.0)).unwrap();
        let foot = sphere.closest_point(&query).unwrap();
        let arm = query - at;
        assert!(((foot.point_mm - at).norm() - sphere.radius_mm()).abs() < FOOT_TOL_MM);
        assert!((foot.point_mm - at).cross(&arm).norm() < FOOT_TOL_MM * arm.norm());
        assert!((foot.signed_distance_mm - (arm.norm() - sphere.radius_mm())).abs() < FOOT_TOL_MM);
    }
}
