//! Lengths in another unit give the same answers in that unit.

use geometry::nalgebra::Point3;
use geometry::{Asphere, AsphereShape, Line, Surface};
use rand::RngExt;

use crate::aspheres::{random_point, shapes};
use crate::regimes::{rng, vector};

/// Powers of two, so that scaling itself rounds nothing.
const UNITS: [f64; 3] = [1.0 / 1024.0, 1024.0, 1_048_576.0];

/// Iterations may take another last bit.
const RELATIVE_TOL: f64 = 64.0 * f64::EPSILON;

fn scaled(shape: &AsphereShape, unit: f64) -> AsphereShape {
    let exponents = (0..).map(|i| -3 - 2 * i);
    let coefficients =
        shape.coefficients.iter().zip(exponents).map(|(a, n)| a * unit.powi(n)).collect();
    AsphereShape {
        radius_mm: shape.radius_mm * unit,
        conic: shape.conic,
        coefficients,
        diameter_mm: shape.diameter_mm * unit,
        aperture_center_mm: shape.aperture_center_mm * unit,
    }
}

#[test]
fn closest_points_and_hits_scale() {
    for shape in shapes() {
        let asphere = Asphere::new(shape.clone()).unwrap();
        for unit in UNITS {
            let other = Asphere::new(scaled(&shape, unit)).unwrap();
            let mut rng = rng(71);
            for _ in 0..100 {
                let away = rng.random_range(0.0..5.0);
                let query = random_point(&shape, &mut rng) + vector(&mut rng, away);
                let size = query.coords.norm() + shape.diameter_mm;
                let here = asphere.closest_point(&query);
                let there = other.closest_point(&(query * unit));
                match (here, there) {
                    (Ok(here), Ok(there)) => {
                        let apart = (there.point_mm / unit - here.point_mm).norm();
                        assert!(apart < RELATIVE_TOL * size / here.normal.z, "{shape:?} {query}");
                    }
                    (here, there) => assert_eq!(
                        here.map(drop).map_err(|e| std::mem::discriminant(&e)),
                        there.map(drop).map_err(|e| std::mem::discriminant(&e)),
                    ),
                }
                let direction = Point3::origin() - Point3::from(vector(&mut rng, 1.0));
                let line = Line::new(query, direction).unwrap();
                let long = Line::new(query * unit, direction).unwrap();
                let here = asphere.hits(&line).unwrap_or_default();
                let there = other.hits(&long).unwrap_or_default();
                assert_eq!(here.len(), there.len());
                for (here, there) in here.iter().zip(&there) {
                    let cosine = here.normal.dot(&line.direction).abs();
                    let apart = (there.distance_mm / unit - here.distance_mm).abs();
                    assert!(apart < RELATIVE_TOL * size / (cosine * here.normal.z), "{shape:?}");
                }
            }
        }
    }
}
