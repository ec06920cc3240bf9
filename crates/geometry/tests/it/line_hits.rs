//! Hits of lines: on line and surface, complete, in order.

use geometry::nalgebra::{Point3, Vector3};
use geometry::{Asphere, AsphereShape, GeometryError, Hit, Line, Plane, Sphere, Surface};
use rand::RngExt;

use crate::aspheres::{aspheres, random_point, reach_mm, sag_mm};
use crate::regimes::{rng, vector};

/// Coordinates up to 1e3 mm over a few operations.
const HIT_TOL_MM: f64 = 1e-12;

fn assert_ascending(hits: &[Hit]) {
    assert!(hits.windows(2).all(|pair| pair[0].distance_mm < pair[1].distance_mm));
}

/// Distances from the aperture's centre of all crossings of the extended surface, by sign changes
/// over a fine sampling.
fn sampled_crossings(shape: &AsphereShape, line: &Line) -> Vec<f64> {
    let n_steps = 20_000_u32;
    let span = 4.0 * reach_mm(shape);
    let height = |i: u32| {
        let p = line.at(span * (2.0 * f64::from(i) / f64::from(n_steps) - 1.0));
        let off_center = (p.xy() - shape.aperture_center_mm).norm();
        (p.z - sag_mm(shape, p.x.hypot(p.y)), off_center)
    };
    let heights: Vec<_> = (0..=n_steps).map(height).collect();
    // NaN, beyond the end of a conic, is not a sign change.
    heights.windows(2).filter(|pair| pair[0].0 * pair[1].0 <= 0.0).map(|pair| pair[0].1).collect()
}

#[test]
fn every_hit_of_a_line_is_found() {
    let mut rng = rng(61);
    let mut n_hits = [0; 5];
    for asphere in aspheres() {
        let shape = asphere.shape();
        for i in 0..60 {
            let through = random_point(shape, &mut rng);
            // Steep, then grazing.
            let mut direction = vector(&mut rng, 1.0);
            direction.z *= [1.0, 0.05][i % 2];
            let back = rng.random_range(-50.0..50.0);
            let direction = direction.normalize();
            let line = Line::new(through - direction * back, direction).unwrap();
            let hits = asphere.hits(&line).unwrap();
            assert_ascending(&hits);
            assert!(
                hits.iter().any(|hit| (hit.distance_mm - back).abs() < 1e-9),
                "{shape:?} {line:?}"
            );
            for hit in &hits {
                let p = hit.point_mm;
                let off = (p.z - sag_mm(shape, p.x.hypot(p.y))).abs() * hit.normal.z;
                assert!(off < HIT_TOL_MM, "{shape:?}: {off}");
                assert!((line.at(hit.distance_mm) - p).norm() < HIT_TOL_MM);
                let normal = asphere.normal(p.x, p.y).unwrap();
                assert!((normal.into_inner() - hit.normal.into_inner()).norm() < 1e-14);
                assert!(asphere.contains(p.x, p.y));
            }
            let rim = 0.5 * shape.diameter_mm;
            let crossings = sampled_crossings(shape, &line);
            // What the sampling cannot place inside or outside the rim is left out.
            if crossings.iter().all(|off_center| (off_center - rim).abs() > 0.1) {
                let n_inside = crossings.iter().filter(|off_center| **off_center < rim).count();
                assert_eq!(hits.len(), n_inside, "{shape:?} {line:?}");
            }
            n_hits[hits.len()] += 1;
        }
    }
    // Single, double and, on the gull wing, more hits all occur.
    assert!(n_hits[1] > 0 && n_hits[2] > 0 && n_hits[3] + n_hits[4] > 0, "{n_hits:?}");
}

#[test]
fn the_first_hit_is_the_first_ahead() {
    let mut rng = rng(62);
    let sphere = Sphere::new(Point3::new(5.0, -3.0, 2.0), 20.0).unwrap();
    let plane = Plane::new(Point3::new(0.0, 0.0, 4.0), Vector3::new(0.1, -0.2, 1.0)).unwrap();
    let aspheres = aspheres();
    let surfaces: Vec<&dyn Surface> =
        aspheres.iter().map(|a| a as &dyn Surface).chain([&sphere as _, &plane as _]).collect();
    for surface in surfaces {
        let mut n_behind = 0;
        for _ in 0..200 {
            let start = Point3::from(vector(&mut rng, 30.0));
            let ray = Line::new(start, vector(&mut rng, 1.0)).unwrap();
            let hits = surface.hits(&ray).unwrap_or_default();
            let ahead = hits.iter().find(|hit| hit.distance_mm >= 0.0);
            match surface.first_hit(&ray) {
                Ok(hit) => {
                    let expected = ahead.unwrap_or_else(|| panic!("{surface:?} {ray:?}"));
                    assert!((hit.distance_mm - expected.distance_mm).abs() < HIT_TOL_MM);
                }
                Err(GeometryError::BehindRay { distance_mm }) => {
                    let last = hits.last().unwrap();
                    assert!(ahead.is_none());
                    assert!((distance_mm + last.distance_mm).abs() < HIT_TOL_MM);
                    n_behind += 1;
                }
                Err(_) => assert!(hits.is_empty(), "{surface:?} {ray:?} {hits:?}"),
            }
        }
        assert!(n_behind > 0, "{surface:?}");
    }
}

#[test]
fn axial_lines_meet_the_sag() {
    for asphere in aspheres() {
        let c = asphere.shape().aperture_center_mm;
        for (dx, dy) in [(0.0, 0.0), (3.0, -4.0)] {
            let (x, y) = (c.x + dx, c.y + dy);
            for down in [-1.0, 1.0] {
                let line = Line::new(Point3::new(x, y, 1e3), Vector3::z() * down).unwrap();
                let hits = asphere.hits(&line).unwrap();
                assert_eq!(hits.len(), 1);
                let error = hits[0].point_mm.z - asphere.sag_mm(x, y).unwrap();
                assert!(error.abs() < HIT_TOL_MM);
            }
            // Nearly axial, 1e-9 rad: the same height but for the slope of 1e3 mm · 1e-9.
            let tilted = Line::new(Point3::new(x, y, 1e3), Vector3::new(1e-9, 0.0, -1.0)).unwrap();
            let hit = asphere.first_hit(&tilted).unwrap();
            let error = hit.point_mm.z - asphere.sag_mm(hit.point_mm.x, y).unwrap();
            assert!(error.abs() < HIT_TOL_MM);
        }
    }
}

#[test]
fn tangents_touch_once_and_near_misses_miss() {
    let dome = Asphere::new(AsphereShape::on_axis(-50.0, 0.0, vec![], 60.0)).unwrap();
    let sphere = Sphere::new(Point3::new(0.0, 0.0, -50.0), 50.0).unwrap();
    let over = |z: f64| Line::new(Point3::new(-100.0, 0.0, z), Vector3::x()).unwrap();
    let hits = dome.hits(&over(0.0)).unwrap();
    assert_eq!(hits.len(), 1);
    // Touching is flat: round-off of 1e-13 in height is √(2 · 50 · 1e-13) along the line.
    assert!(hits[0].point_mm.coords.norm() < 1e-5);
    assert_eq!(sphere.hits(&over(0.0)).unwrap().len(), 1);
    for surface in [&dome as &dyn Surface, &sphere] {
        assert_eq!(surface.hits(&over(1e-9)), Err(GeometryError::Misses));
        let hits = surface.hits(&over(-1e-9)).unwrap();
        assert_eq!(hits.len(), 2);
        // Half a chord is √(2 R · 1e-9).
        let chord = hits[1].distance_mm - hits[0].distance_mm;
        assert!((chord - 2.0 * (100.0 * 1e-9_f64).sqrt()).abs() < 1e-6, "{chord}");
    }
}

#[test]
fn lines_that_pass_by_say_how() {
    let asphere = Asphere::new(AsphereShape::on_axis(25.0, 0.0, vec![], 40.0)).unwrap();
    let down = |x: f64| Line::new(Point3::new(x, 0.0, 50.0), -Vector3::z()).unwrap();
    assert!(asphere.hits(&down(19.9)).is_ok());
    for x in [20.1, 24.9] {
        let said = asphere.hits(&down(x));
        assert!(matches!(said, Err(GeometryError::OutsideAperture { .. })), "{x}: {said:?}");
    }
    let said = asphere.first_hit(&down(30.0));
    assert!(matches!(said, Err(GeometryError::SagUndefined { .. })), "{said:?}");
    let above = Line::new(Point3::new(0.0, 0.0, 30.0), Vector3::x()).unwrap();
    assert_eq!(asphere.hits(&above), Err(GeometryError::Misses));

    let away = down(3.0).reversed();
    let said = asphere.first_hit(&away);
    assert!(matches!(said, Err(GeometryError::BehindRay { distance_mm }) if distance_mm > 49.0));

    let plane = Plane::new(Point3::origin(), Vector3::z()).unwrap();
    let level = |z: f64| Line::new(Point3::new(1.0, 2.0, z), Vector3::x()).unwrap();
    assert_eq!(plane.hits(&level(1e-9)), Err(GeometryError::Misses));
    assert_eq!(plane.hits(&level(0.0)), Err(GeometryError::LineInSurface));
    let flat = Asphere::new(AsphereShape::on_axis(f64::INFINITY, 0.0, vec![], 10.0)).unwrap();
    assert_eq!(flat.hits(&level(0.0)), Err(GeometryError::LineInSurface));
}
