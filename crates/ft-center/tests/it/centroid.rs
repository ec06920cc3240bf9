//! Force centre and removal centre against quadrature over the pad.

use std::f64::consts::TAU;

use ft_center::{FtCenterError, pressure_centroid_mm, removal_centroid_mm};
use nalgebra::Vector2;

/// Midpoint rule with 400 rings (relative error 1/(12·400²)·few) and 400 sectors (exact).
const QUADRATURE_TOL: f64 = 2e-5;

/// First moment over the integral of a density `p(x, y)·v(r)` on a disc.
fn centroid(
    radius: f64,
    pressure: impl Fn(f64, f64) -> f64,
    speed: impl Fn(f64) -> f64,
) -> Vector2<f64> {
    let n = 400;
    let (mut sum, mut moment) = (0.0, Vector2::zeros());
    for ring in 0..n {
        let r = radius * (f64::from(ring) + 0.5) / f64::from(n);
        for sector in 0..n {
            let angle = TAU * (f64::from(sector) + 0.5) / f64::from(n);
            let at = r * Vector2::new(angle.cos(), angle.sin());
            let density = pressure(at.x, at.y) * speed(r) * r;
            sum += density;
            moment += at * density;
        }
    }
    moment / sum
}

#[test]
fn formulas_match_quadrature() {
    for (g, radius) in [([0.004, 0.0], 25.0), ([0.01, -0.02], 40.0), ([0.0, 0.1], 10.0)] {
        let g = Vector2::from(g);
        let pressure = |x: f64, y: f64| 1.0 + g.x * x + g.y * y;
        let force = centroid(radius, pressure, |_| 1.0);
        let removal = centroid(radius, pressure, |r| r);
        let size = g.norm() * radius * radius;
        let expected = pressure_centroid_mm(g, radius).unwrap();
        assert!((force - expected).norm() < QUADRATURE_TOL * size, "{force} {expected}");
        let expected = removal_centroid_mm(g, radius).unwrap();
        assert!((removal - expected).norm() < QUADRATURE_TOL * size, "{removal} {expected}");
    }
}

#[test]
fn a_pad_that_lifts_off_is_an_error() {
    let g = Vector2::new(0.03, 0.03);
    assert!(pressure_centroid_mm(g, 23.0).is_ok());
    let error = removal_centroid_mm(g, 24.0).unwrap_err();
    assert!(matches!(error, FtCenterError::PadLiftsOff { radius_mm: 24.0, .. }));
    assert!(pressure_centroid_mm(Vector2::new(f64::NAN, 0.0), 1.0).is_err());
    assert!(pressure_centroid_mm(Vector2::zeros(), 0.0).is_err());
}
