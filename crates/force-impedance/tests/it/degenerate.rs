//! Nothing panics on bad input, and every refusal has a reason.

use force_impedance::{ForceImpedanceError as E, Head, HeadGeometry, HeadLimits};
use nalgebra::{Point3, Vector3};

use crate::usual_head::{GEOMETRY, head};

#[test]
fn impossible_heads_are_refused() {
    let wide = HeadLimits::wide(&GEOMETRY);
    let refuse = |geometry: HeadGeometry| Head::new(geometry, wide).unwrap_err();
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let setting = |e: E| matches!(e, E::InvalidSetting { .. });
        assert!(setting(refuse(HeadGeometry { tip_to_plane_mm: bad, ..GEOMETRY })));
        assert!(setting(refuse(HeadGeometry { plane_to_joint_mm: bad, ..GEOMETRY })));
        assert!(setting(refuse(HeadGeometry { head_radius_mm: bad, ..GEOMETRY })));
        assert!(setting(refuse(HeadGeometry { bracket_radius_mm: bad, ..GEOMETRY })));
        let limits = HeadLimits { tilt_rad: bad, ..wide };
        assert!(setting(Head::new(GEOMETRY, limits).unwrap_err()));
    }
    assert!(matches!(
        refuse(HeadGeometry { bracket_radius_mm: 40.0, ..GEOMETRY }),
        E::InvalidSetting { .. }
    ));
    assert!(matches!(
        refuse(HeadGeometry { gravity_direction: Vector3::new(0.0, 0.0, -2.0), ..GEOMETRY }),
        E::NotAUnitVector { .. }
    ));
    // Three legs in one line hold only one tilt.
    for angles in [[0.5, 0.5, 0.5], [0.0, std::f64::consts::PI, 0.0]] {
        let e = refuse(HeadGeometry { leg_angles_rad: angles, ..GEOMETRY });
        assert!(matches!(e, E::LegsDoNotHold { .. }), "{e}");
    }
}

#[test]
fn readings_that_are_no_numbers_are_refused() {
    let head = head();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let lengths_mm = [70.0, bad, 70.0, 180.0];
        let e = head.pose_of_lengths(&lengths_mm).unwrap_err();
        assert_eq!(e.to_string(), "length 2 (counted from 1) is not finite");
        assert!(head.pose_at(&Point3::new(bad, -300.0, 0.0)).is_err());
    }
    for hostile in [[0.0; 4], [1e300; 4], [70.0, 70.0, 70.0, -180.0], [1.0, 1.0, 300.0, 180.0]] {
        let e = head.pose_of_lengths(&hostile).unwrap_err();
        assert!(!e.to_string().is_empty());
    }
    assert!(head.pose_at(&Point3::origin()).is_err());
    assert!(head.pose_at(&Point3::new(0.0, 300.0, 0.0)).is_err());
}

#[test]
fn the_published_formula_refuses_a_surface_along_the_tool() {
    let head = head();
    let balance = head.balance(&head.pose_at(&head.start_tip_mm()).unwrap());
    let e = balance.published_normal_n(&[1.0; 4], &Vector3::x()).unwrap_err();
    assert!(matches!(e, E::NormalAcrossAxis { .. }), "{e}");
}
