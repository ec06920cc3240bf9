//! Hostile and hopeless input.

use std::sync::Arc;

use geometry::{Asphere, AsphereShape};
use model_discrepancy::{Covariate, Quantity};
use nalgebra::{Point2, Point3, Vector3};
use probe_comp::{
    BallTouch, Contact, InvalidTouch, Nominal, NormalSource, ProbeError, ProbeModel, Side,
    compensate, micro_radius,
};

use crate::scene::{TIP_MM, bowl, bowl_height, let_down, measured, reference_sphere, setup};

fn touch(x: f64, y: f64) -> BallTouch {
    BallTouch::new(let_down(bowl_height, x, y, TIP_MM), 1e-3)
}

fn on_bowl(touches: &[BallTouch], source: NormalSource) -> Result<Vec<Contact>, ProbeError> {
    compensate(&bowl(), TIP_MM, touches, source)
}

#[test]
fn touches_that_are_none() {
    let good = touch(1.0, 2.0);
    assert_eq!(on_bowl(&[], NormalSource::Nominal), Ok(vec![]));
    for value in [f64::NAN, f64::INFINITY, 1e10] {
        let bad = BallTouch { center_mm: Point3::new(value, 0.0, 3.0), ..good.clone() };
        let error = on_bowl(&[good.clone(), bad], NormalSource::Nominal).unwrap_err();
        assert!(
            matches!(
                error,
                ProbeError::InvalidTouch { index: 1, reason: InvalidTouch::Coordinate { .. } }
            ),
            "{error}"
        );
    }
    for sigma_mm in [0.0, -1.0, f64::NAN] {
        let bad = BallTouch { sigma_mm, ..good.clone() };
        let error = on_bowl(&[bad], NormalSource::Nominal).unwrap_err();
        assert!(error.to_string().contains("touch 1: standard uncertainty"), "{error}");
    }
    let away = BallTouch { approach: Some(Vector3::z_axis()), ..good.clone() };
    let error = on_bowl(&[good.clone(), away], NormalSource::Nominal).unwrap_err();
    assert!(error.to_string().starts_with("touch 2: the approach points away"), "{error}");
    assert_eq!(error.touch(), Some(1));
    let far = BallTouch::new(good.center_mm + Vector3::z() * 40.0, 1e-3);
    let error = on_bowl(&[far], NormalSource::Nominal).unwrap_err();
    assert!(matches!(error, ProbeError::FarFromSurface { index: 0, .. }), "{error}");
    assert!(!error.to_string().contains("session"), "{error}");
    let all: Vec<BallTouch> = (0..8)
        .map(|i| {
            let lift = if i % 2 == 0 { 0.0 } else { 40.0 };
            BallTouch::new(good.center_mm + Vector3::z() * lift, 1e-3)
        })
        .collect();
    let error = on_bowl(&all, NormalSource::Nominal).unwrap_err();
    assert!(matches!(error, ProbeError::FarFromSurface { index: 1, far: 4, of: 8, .. }), "{error}");
    assert!(error.to_string().contains("4 of 8 touches are as far"), "{error}");
    let lost = BallTouch { guide_mm: Some(Point2::new(900.0, 0.0)), ..good.clone() };
    let error = on_bowl(&[lost], NormalSource::Nominal).unwrap_err();
    assert!(matches!(error, ProbeError::NoGuide { index: 0 }), "{error}");
    for radius_mm in [-1.0, f64::NAN, f64::INFINITY] {
        let error =
            compensate(&bowl(), radius_mm, std::slice::from_ref(&good), NormalSource::Nominal);
        assert!(matches!(error, Err(ProbeError::InvalidTip { .. })));
    }
}

#[test]
fn a_ball_that_is_too_large_is_told_so() {
    let hollow = Asphere::new(AsphereShape::on_axis(2.5, 0.0, vec![], 4.0)).unwrap();
    let nominal = Nominal::new(Arc::new(hollow), Side::Along);
    // Above the centre of curvature, where the ball hangs between the walls.
    for z in [2.5, 2.9] {
        let touch = BallTouch::new(Point3::new(0.0, 0.0, z), 1e-3);
        let error = compensate(&nominal, TIP_MM, &[touch], NormalSource::Nominal).unwrap_err();
        let hollow_radius_mm = match error {
            ProbeError::TipTooLarge { index: 0, hollow_radius_mm, .. } => hollow_radius_mm,
            other => panic!("{other}"),
        };
        assert!((hollow_radius_mm - 2.5).abs() < 1e-9);
    }
    let seat = reference_sphere(Side::Against);
    let touch = BallTouch::new(Point3::new(40.5, -20.0, 15.0), 1e-3);
    let error = compensate(&seat, 25.0, &[touch], NormalSource::Nominal).unwrap_err();
    assert!(matches!(error, ProbeError::TipTooLarge { .. }), "{error}");
}

#[test]
fn at_the_medial_axis_no_foot_is_made_up() {
    let touch = BallTouch::new(Point3::new(40.0, -20.0, 15.0), 1e-3);
    let ball = reference_sphere(Side::Against);
    let error = compensate(&ball, TIP_MM, &[touch], NormalSource::Nominal).unwrap_err();
    assert!(matches!(error, ProbeError::NoFoot { index: 0, .. }), "{error}");
}

#[test]
fn neighbours_that_make_no_plane() {
    let with = |places: &[[f64; 2]]| BallTouch {
        micro_mm: places.iter().map(|[x, y]| touch(*x, *y).center_mm).collect(),
        ..touch(0.0, 0.0)
    };
    let by = |touch: BallTouch, source| on_bowl(&[touch], source).unwrap_err();
    let error = by(with(&[[0.1, 0.0], [-0.1, 0.0]]), NormalSource::MicroPlane);
    assert_eq!(error, ProbeError::TooFewNeighbours { index: 0, got: 2, needed: 3 });
    let line = with(&[[0.1, 0.0], [0.0, 0.0], [-0.1, 0.0]]);
    let error = by(line, NormalSource::MicroPlane);
    assert!(matches!(error, ProbeError::NeighboursOnALine { index: 0, .. }), "{error}");
    let point = with(&[[0.1, 0.1]; 4]);
    let error = by(point, NormalSource::MicroPlane);
    assert!(matches!(error, ProbeError::NeighboursOnALine { .. }), "{error}");
    // As thin at any distance: 5 nm across 80 mm.
    let thin = with(&[[40.0, 0.0], [-40.0, 0.0], [0.0, 1e-5]]);
    let error = by(thin, NormalSource::MicroPlane);
    assert!(matches!(error, ProbeError::NeighboursOnALine { .. }), "{error}");
    let square = with(&[[0.1, 0.1], [-0.1, 0.1], [-0.1, -0.1], [0.1, -0.1]]);
    assert_eq!(
        by(square, NormalSource::Quadric),
        ProbeError::TooFewNeighbours { index: 0, got: 4, needed: 5 }
    );
    assert_eq!(by(touch(0.0, 0.0), NormalSource::Approach), ProbeError::NoApproach { index: 0 });
}

#[test]
fn radii_of_a_micro_plane_that_cannot_be() {
    let range = [0.05, 0.5];
    assert!(micro_radius(TIP_MM, 0.0, [0.0, 0.0], range).is_err());
    assert!(micro_radius(TIP_MM, 1e-3, [0.0, 0.0], [0.5, 0.5]).is_err());
    let error = micro_radius(TIP_MM, 1e-3, [0.4, 0.0], range).unwrap_err();
    assert!(matches!(error, ProbeError::TipTooLarge { .. }), "{error}");
    // A plane or a sphere has no bias: the largest circle is the best.
    let flat = micro_radius(TIP_MM, 1e-3, [-0.01, -0.01], range).unwrap();
    assert_eq!((flat.radius_mm, flat.bias_mm), (0.5, 0.0));
}

#[test]
fn covariates_that_do_not_fit() {
    let touches = || measured(vec![touch(0.0, 0.0), touch(5.0, 1.0)]);
    for values in [vec![1.0], vec![1.0, f64::NAN]] {
        let column = Covariate::recorded("x", Quantity::Other, values);
        let error = ProbeModel::new(setup(bowl()), touches(), &[column]).unwrap_err();
        assert!(matches!(error, ProbeError::InvalidCovariate { needed: 2, .. }), "{error}");
    }
}
