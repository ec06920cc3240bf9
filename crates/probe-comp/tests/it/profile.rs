//! The two-dimensional method of document [E].

use nalgebra::Vector2;
use probe_comp::{ProbeError, compensate_profile};

use crate::scene::TIP_MM;

/// Ball centres over a circular hump of radius 50 mm, at x − h, x, x + h.
fn over_a_circle(places: &[f64]) -> Vec<Vector2<f64>> {
    let reach = 50.0 + TIP_MM;
    places.iter().map(|x| Vector2::new(*x, (reach * reach - x * x).sqrt() - 50.0)).collect()
}

#[test]
fn contacts_lie_on_the_profile() {
    let places: Vec<f64> = (0..81).map(|i| 0.5 * f64::from(i) - 20.0).collect();
    let contacts = compensate_profile(&over_a_circle(&places), TIP_MM, 1e-3).unwrap();
    assert_eq!(contacts.len(), places.len() - 2);
    for c in contacts {
        // The circle's centre is 50 mm below the origin. Neighbours at ±h leave a third-order
        // term h² z'''/6 < 4e-5 in the slope at 20 mm: r² times its square over 2R, and r times it
        // along the profile.
        let arm = c.point_mm + Vector2::new(0.0, 50.0);
        assert!((arm.norm() - 50.0).abs() < 1e-7, "{c:?}");
        assert!((c.inclination_rad.sin() - c.center_mm.x / 53.0).abs() < 5e-5, "{c:?}");
        // Two heights of 1 µm a millimetre apart.
        let expected = 2f64.sqrt() * 1e-3 * c.inclination_rad.cos().powi(2);
        assert!((c.sigma_inclination_rad / expected - 1.0).abs() < 1e-9);
    }
}

#[test]
fn uneven_steps_keep_the_slope_of_a_parabola() {
    let parabola: Vec<_> = [-2.0, -1.4, 0.3, 0.5, 1.7]
        .iter()
        .map(|x| Vector2::new(*x, 0.02 * x * x + 0.1 * x))
        .collect();
    for c in compensate_profile(&parabola, TIP_MM, 1e-3).unwrap() {
        assert!((c.inclination_rad.tan() + 0.04 * c.center_mm.x + 0.1).abs() < 1e-13);
    }
}

#[test]
fn profiles_that_are_none() {
    let two = over_a_circle(&[0.0, 1.0]);
    assert_eq!(compensate_profile(&two, TIP_MM, 1e-3), Err(ProbeError::InvalidProfile { got: 2 }));
    let back = over_a_circle(&[0.0, 1.0, 0.5]);
    assert_eq!(compensate_profile(&back, TIP_MM, 1e-3), Err(ProbeError::InvalidProfile { got: 3 }));
    let good = over_a_circle(&[0.0, 1.0, 2.0]);
    assert!(matches!(
        compensate_profile(&good, f64::NAN, 1e-3),
        Err(ProbeError::InvalidTip { .. })
    ));
}
