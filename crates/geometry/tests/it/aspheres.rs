//! Aspheres to test on, and a reference that shares no code with the crate.

use std::f64::consts::PI;

use geometry::nalgebra::{Point2, Point3};
use geometry::{Asphere, AsphereShape};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Feet and hits are sought to this multiple of the rim's radius, as the crate documents.
pub(crate) const MARGIN_RATIO: f64 = 1.25;

pub(crate) fn shapes() -> Vec<AsphereShape> {
    let on_axis = |radius, conic, coefficients: &[f64], diameter| {
        AsphereShape::on_axis(radius, conic, coefficients.to_vec(), diameter)
    };
    vec![
        // The paraboloid of document [D].
        on_axis(480.0, -1.0, &[], 100.0),
        on_axis(50.0, 0.0, &[], 60.0),
        on_axis(-80.0, -2.5, &[], 70.0),
        on_axis(40.0, 1.5, &[], 30.0),
        // A camera lens: dome with four even terms.
        on_axis(-21.0, -0.7, &[3e-6, -2.5e-8, 1.2e-10, -2e-13], 24.0),
        // Flat base, a Schmidt corrector.
        on_axis(f64::INFINITY, 0.0, &[-2e-7, 5e-11], 120.0),
        // A gull wing: the meridian's curvature changes sign within the aperture.
        on_axis(60.0, -1.0, &[-1.2e-5], 50.0),
        // Nearly a hemisphere.
        on_axis(25.0, 0.0, &[], 49.0),
        // Off-axis paraboloid.
        AsphereShape {
            radius_mm: 300.0,
            conic: -1.0,
            coefficients: vec![],
            diameter_mm: 50.0,
            aperture_center_mm: Point2::new(60.0, -40.0),
        },
    ]
}

pub(crate) fn aspheres() -> Vec<Asphere> {
    shapes().into_iter().map(|shape| Asphere::new(shape).expect("valid shape")).collect()
}

pub(crate) fn rim_mm(shape: &AsphereShape) -> f64 {
    shape.aperture_center_mm.coords.norm() + 0.5 * shape.diameter_mm
}

/// Distance from the axis to which feet and hits are sought.
pub(crate) fn reach_mm(shape: &AsphereShape) -> f64 {
    let rim = rim_mm(shape);
    let squeeze = (1.0 + shape.conic) / shape.radius_mm.powi(2);
    let limit = if squeeze > 0.0 { 1.0 / squeeze.sqrt() } else { f64::INFINITY };
    rim.max((MARGIN_RATIO * rim).min(0.999 * limit))
}

/// Sag from the definition in ISO 10110-12, term by term.
pub(crate) fn sag_mm(shape: &AsphereShape, r: f64) -> f64 {
    let big_r = shape.radius_mm;
    let root = (1.0 - (1.0 + shape.conic) * (r / big_r).powi(2)).sqrt();
    let mut z = r * r / (big_r * (1.0 + root));
    let mut power = 4;
    for a in &shape.coefficients {
        z += a * r.powi(power);
        power += 2;
    }
    z
}

/// Largest |curvature| of the meridian, sampled.
pub(crate) fn max_curvature_per_mm(shape: &AsphereShape) -> f64 {
    let (reach, h) = (reach_mm(shape), 1e-4 * reach_mm(shape));
    (1..2000_u32)
        .map(|i| {
            let r = (reach - 2.0 * h) * f64::from(i) / 2000.0;
            let [before, at, after] = [r - h, r, r + h].map(|r| sag_mm(shape, r));
            let slope = (after - before) / (2.0 * h);
            ((after - 2.0 * at + before) / (h * h) / (1.0 + slope * slope).powf(1.5)).abs()
        })
        .fold(0.0, f64::max)
}

/// A point of the surface within the aperture.
pub(crate) fn random_point(shape: &AsphereShape, rng: &mut ChaCha8Rng) -> Point3<f64> {
    let angle = rng.random_range(-PI..PI);
    let r = 0.5 * shape.diameter_mm * rng.random_range(0.0_f64..1.0).sqrt();
    let x = shape.aperture_center_mm.x + r * angle.cos();
    let y = shape.aperture_center_mm.y + r * angle.sin();
    Point3::new(x, y, sag_mm(shape, x.hypot(y)))
}
