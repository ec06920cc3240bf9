//! Surfaces and balls on them, written apart from the crate.

use std::sync::Arc;

use geometry::{Asphere, AsphereShape, Polynomial, Sphere};
use nalgebra::{Point3, Vector3};
use probe_comp::{BallTouch, MeasuredTouch, Nominal, ProbeSetup, Side};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

pub(crate) const TIP_MM: f64 = 3.0;
pub(crate) const BOWL_MM: f64 = 120.0;

/// A height over xy with its slopes.
pub(crate) type Height = fn(f64, f64) -> [f64; 3];

/// Cylinder of radius 50 mm along y, hump up, at its crest.
pub(crate) fn cylinder(x: f64, _y: f64) -> [f64; 3] {
    [-x * x / 100.0, -x / 50.0, 0.0]
}

/// Saddle of radii ±50 mm.
pub(crate) fn saddle(x: f64, y: f64) -> [f64; 3] {
    [(y * y - x * x) / 100.0, -x / 50.0, y / 50.0]
}

/// Off the axes of a freeform with third-order terms.
pub(crate) fn freeform(x: f64, y: f64) -> [f64; 3] {
    let z = 0.004 * x * x - 0.006 * y * y + 0.003 * x * y + 4e-5 * x * x * x - 3e-5 * x * y * y;
    let slope_x = 0.008 * x + 0.003 * y + 1.2e-4 * x * x - 3e-5 * y * y;
    [z, slope_x, -0.012 * y + 0.003 * x - 6e-5 * x * y]
}

pub(crate) fn bowl_height(x: f64, y: f64) -> [f64; 3] {
    [(x * x + y * y) / (2.0 * BOWL_MM), x / BOWL_MM, y / BOWL_MM]
}

/// The same surfaces as the crate takes them.
pub(crate) fn polynomials() -> [(Height, Nominal); 3] {
    let nominal = |terms: Vec<(usize, usize, f64)>| {
        Nominal::new(Arc::new(Polynomial::new(1.0, terms).unwrap()), Side::Along)
    };
    [
        (cylinder, nominal(vec![(2, 0, -0.01)])),
        (saddle, nominal(vec![(2, 0, -0.01), (0, 2, 0.01)])),
        (
            freeform,
            nominal(vec![
                (2, 0, 0.004),
                (0, 2, -0.006),
                (1, 1, 0.003),
                (3, 0, 4e-5),
                (1, 2, -3e-5),
            ]),
        ),
    ]
}

pub(crate) fn bowl() -> Nominal {
    let shape = AsphereShape::on_axis(BOWL_MM, -1.0, vec![], 100.0);
    Nominal::new(Arc::new(Asphere::new(shape).unwrap()), Side::Along)
}

pub(crate) fn reference_sphere(side: Side) -> Nominal {
    Nominal::sphere(Sphere::new(Point3::new(40.0, -20.0, 15.0), 25.0).unwrap(), side)
}

pub(crate) fn normal_of(height: Height, x: f64, y: f64) -> Vector3<f64> {
    let [_, slope_x, slope_y] = height(x, y);
    Vector3::new(-slope_x, -slope_y, 1.0).normalize()
}

pub(crate) fn point_of(height: Height, x: f64, y: f64) -> Point3<f64> {
    Point3::new(x, y, height(x, y)[0])
}

/// Centre of the ball that is let down at (x, y), by fixed-point iteration over its contact.
pub(crate) fn let_down(height: Height, x: f64, y: f64, tip_mm: f64) -> Point3<f64> {
    let (mut u, mut v) = (x, y);
    for _ in 0..200 {
        let normal = normal_of(height, u, v);
        (u, v) = (x - tip_mm * normal.x, y - tip_mm * normal.y);
    }
    point_of(height, u, v) + normal_of(height, u, v) * tip_mm
}

pub(crate) fn noise(sigma_mm: f64, rng: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| { let n: f64 = StandardNormal.sample(rng); n } * sigma_mm)
}

/// Directions over the upper half of a sphere, evenly.
pub(crate) fn directions(n: u32) -> Vec<Vector3<f64>> {
    (0..n)
        .map(|i| {
            let z = (f64::from(i) + 0.5) / f64::from(n);
            let (sin, cos) = (2.399_963 * f64::from(i)).sin_cos();
            let side = (1.0 - z * z).sqrt();
            Vector3::new(side * cos, side * sin, z)
        })
        .collect()
}

pub(crate) fn measured(touches: Vec<BallTouch>) -> Vec<MeasuredTouch> {
    let named = |(i, touch): (usize, BallTouch)| MeasuredTouch {
        name: format!("T{i}"),
        group: format!("T{i}"),
        role: model_discrepancy::Role::Fit,
        touch,
    };
    touches.into_iter().enumerate().map(named).collect()
}

pub(crate) fn setup(nominal: Nominal) -> ProbeSetup {
    ProbeSetup {
        nominal,
        tip_radius_mm: TIP_MM,
        stylus: Vector3::z_axis(),
        source: probe_comp::NormalSource::Nominal,
        sigma_declared: true,
        qualification: None,
    }
}
