//! Planned contacts at guide points.

use nalgebra::{Point2, Vector3};
use probe_comp::{BallTouch, NormalSource, compensate};

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
