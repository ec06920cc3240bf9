//! Planned contacts at guide points.

use std::sync::Arc;

use geometry::Plane;
use nalgebra::{Point2, Point3, Vector3};
use probe_comp::{BallTouch, Nominal, NormalSource, ProbeError, Side, compensate, guide_point};

use crate::scene::{TIP_MM, bowl, bowl_height, let_down, normal_of};

#[test]
fn the_error_vector_is_that_of_the_part() {
    for (x, y) in [(0.0, 0.0), (12.0, -7.0), (30.0, 25.0)] {
        let planned = let_down(bowl_height, x, y, TIP_MM);
        // The part is 8 µm high along z: the ball stops higher by as much.
        let mut touch = BallTouch::new(planned, 1e-3);
        touch.center_mm.z += 8e-3;
        touch.guide_mm = Some(Point2::new(x, y));
        let contact = &compensate(&bowl(), TIP_MM, &[touch], NormalSource::Nominal).unwrap()[0];
        let found = contact.planned.unwrap();
        assert!((found.center_mm - planned).norm() < 1e-10, "{found:?}");
        let under = found.center_mm - found.point_mm;
        let normal = normal_of(bowl_height, found.point_mm.x, found.point_mm.y);
        assert!((under - normal * TIP_MM).norm() < 1e-10, "{found:?}");
        // A' − A: 8 µm up, but that the normal is taken 8 µm sin θ beside its place, which turns it
        // by less than 3e-5 and the contact by r times that.
        assert!((found.error_mm - Vector3::new(0.0, 0.0, 8e-3)).norm() < 9e-5, "{found:?}");
        assert!((found.normal_error_mm - 8e-3 * normal.z).abs() < 1e-5, "{found:?}");
    }
}

#[test]
fn a_guide_point_has_the_ball_above_it_and_the_contact_beside_it() {
    for (n, (x, y)) in [(0.0, 0.0), (12.0, -7.0), (30.0, 25.0)].into_iter().enumerate() {
        let ball = let_down(bowl_height, x, y, TIP_MM);
        let guide = guide_point(&bowl(), TIP_MM, Point2::new(x, y), 40.0, n).unwrap();
        assert!((guide.center_mm - ball).norm() < 1e-10, "{guide:?}");
        assert!((guide.guide_mm.z - bowl_height(x, y)[0]).abs() < 1e-10);
        let normal = normal_of(bowl_height, guide.point_mm.x, guide.point_mm.y);
        assert!((guide.normal.into_inner() - normal).norm() < 1e-10);
        assert!((guide.center_mm - guide.point_mm - normal * TIP_MM).norm() < 1e-10);
        assert!(guide.inside_aperture);
    }
    let large = guide_point(&bowl(), 1e4, Point2::new(1.0, 2.0), 40.0, 3);
    assert!(matches!(
        large,
        Err(ProbeError::NoGuide { index: 3 } | ProbeError::TipTooLarge { index: 3, .. })
    ));
    let none = guide_point(&bowl(), -1.0, Point2::new(1.0, 2.0), 40.0, 3);
    assert!(matches!(none, Err(ProbeError::InvalidTip { .. })));
}

/// Far from the origin, where the last step that can be told from none is longer.
#[test]
fn a_guide_point_is_found_far_out() {
    // A few roundings of coordinates of 1e5 mm.
    const FAR_TOL_MM: f64 = 1e-9;
    let up = Vector3::new(0.3, -0.2, 1.0).normalize();
    let plane = Nominal::new(Arc::new(Plane::new(Point3::origin(), up).unwrap()), Side::Along);
    for k in 0..40 {
        let (sin, cos) = (2.399_963 * f64::from(k)).sin_cos();
        let (x, y) = (cos * (3e4 + 2e3 * f64::from(k)), sin * 9e4);
        let guide = guide_point(&plane, TIP_MM, Point2::new(x, y), 0.0, 0).unwrap();
        let z = (TIP_MM - up.x * x - up.y * y) / up.z;
        assert!((guide.center_mm - Point3::new(x, y, z)).norm() < FAR_TOL_MM, "{guide:?}");
    }
}
