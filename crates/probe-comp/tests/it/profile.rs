//! The two-dimensional method of document [E].

use std::sync::Arc;

use geometry::Plane;
use nalgebra::{Point3, Vector2, Vector3};
use probe_comp::{
    BallTouch, Nominal, NormalSource, ProbeError, Side, compensate, compensate_profile,
};

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

/// Touches in a row that is turned by 30° in the xy plane, over the hump; in no order.
fn row(places: &[f64]) -> Vec<BallTouch> {
    let (sin, cos) = 30.0_f64.to_radians().sin_cos();
    let at = |p: &Vector2<f64>| Point3::new(5.0 + cos * p.x, -2.0 + sin * p.x, p.y);
    let mut touches: Vec<BallTouch> =
        over_a_circle(places).iter().map(|p| BallTouch::new(at(p), 1e-3)).collect();
    touches.rotate_left(7);
    touches.swap(0, 3);
    touches
}

/// The nominal part: a plane near the hump.
fn plane() -> Nominal {
    let plane = Plane::new(Point3::origin(), Vector3::z()).unwrap();
    Nominal::new(Arc::new(plane), Side::Along)
}

#[test]
fn a_row_of_touches_is_compensated_as_the_profile() {
    let places: Vec<f64> = (0..41).map(|i| 0.5 * f64::from(i) - 10.0).collect();
    let known = compensate_profile(&over_a_circle(&places), TIP_MM, 1e-3).unwrap();
    let touches = row(&places);
    let found = compensate(&plane(), TIP_MM, &touches, NormalSource::Profile).unwrap();
    let (sin, cos) = 30.0_f64.to_radians().sin_cos();
    let mut compared = 0;
    for contact in &found {
        // The centre line of the hump is 50 mm below the origin of the row.
        let arm = contact.point_mm - Point3::new(5.0, -2.0, -50.0);
        let along = cos * arm.x + sin * arm.y;
        // Third-order terms of the outermost slopes: h² z''' is 5e-5 there.
        assert!((along.hypot(arm.z) - 50.0).abs() < 1e-6, "{contact:?}");
        assert!((-sin * arm.x + cos * arm.y).abs() < 1e-12);
        let center = contact.center_mm - Point3::new(5.0, -2.0, 0.0);
        let x = cos * center.x + sin * center.y;
        let Some(same) = known.iter().find(|k| (k.center_mm.x - x).abs() < 1e-9) else { continue };
        compared += 1;
        assert!((same.point_mm.x - along).abs() < 1e-12);
        // The noise of a reading, and along the row that of the normal times the radius; a noise of
        // the place counts with the slope.
        let turned = TIP_MM * same.sigma_inclination_rad / same.inclination_rad.cos();
        let expected = 3e-6 + turned * turned;
        assert!((contact.covariance_mm2.trace() / expected - 1.0).abs() < 1e-9);
    }
    assert_eq!(compared, 39);
    // From below, the normals point down.
    let below = plane().from_side(Side::Against);
    let low: Vec<BallTouch> =
        (0..5).map(|k| BallTouch::new(Point3::new(f64::from(k), 0.0, -TIP_MM), 1e-3)).collect();
    let found = compensate(&below, TIP_MM, &low, NormalSource::Profile).unwrap();
    assert!(found.iter().all(|contact| (contact.normal.z + 1.0).abs() < 1e-12));
}

#[test]
fn rows_that_are_none() {
    let by = |touches: &[BallTouch]| {
        compensate(&plane(), TIP_MM, touches, NormalSource::Profile).unwrap_err()
    };
    let places: Vec<f64> = (0..12).map(f64::from).collect();
    let touches = row(&places);
    assert_eq!(by(&touches[..2]), ProbeError::InvalidProfile { got: 2 });
    let mut beside = touches.clone();
    beside[1].center_mm.x += 0.5;
    let error = by(&beside);
    assert!(matches!(error, ProbeError::BesideProfile { index: 1, .. }), "{error}");
    let mut twice = touches.clone();
    twice[9] = touches[2].clone();
    assert_eq!(by(&twice), ProbeError::SamePlace { index: 9, other: 2 });
    let stacked: Vec<BallTouch> = (0..4)
        .map(|k| BallTouch::new(Point3::new(0.0, 0.0, 3.0 + 1e-3 * f64::from(k)), 1e-3))
        .collect();
    assert!(matches!(by(&stacked), ProbeError::SamePlace { .. }));
}
