//! What touches show of effects, and what these change in a contact.

use std::sync::Arc;

use geometry::Plane;
use model_discrepancy::{Model, Options, Role, close_loop};
use nalgebra::{Point3, Unit, Vector3};
use probe_comp::{BallTouch, Nominal, ProbeModel, Side};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::scene::{TIP_MM, directions, measured, noise, reference_sphere, setup};

const SIGMA_MM: f64 = 1e-3;

/// On a ring, a part that is more curved is one that lies higher; one that is bent is not.
#[test]
fn a_ring_of_touches_does_not_tell_a_focus_from_a_place() {
    let on = |angle: f64, radius_mm: f64| {
        let (sin, cos) = angle.sin_cos();
        BallTouch::new(Point3::new(radius_mm * cos, radius_mm * sin, TIP_MM), SIGMA_MM)
    };
    let ring: Vec<_> = (0..24).map(|k| on(0.26 * f64::from(k), 30.0)).collect();
    let mut rings = ring.clone();
    rings.extend((0..24).map(|k| on(0.26 * f64::from(k), 15.0)));
    let plane = Plane::new(Point3::origin(), Vector3::z()).unwrap();
    let nominal = Nominal::new(Arc::new(plane), Side::Along);
    for (touches, tells) in [(ring, false), (rings, true)] {
        let model = ProbeModel::new(setup(nominal.clone()), measured(touches), &[]).unwrap();
        let has = |id: &str| model.declared().effects.iter().any(|effect| effect.id == id);
        assert_eq!(has("focus"), tells);
        assert!(has("astigmatism"));
    }
}

/// A ball that is larger than declared adds the same to n touches: without their mean, one of them
/// is known to `σ √(1 − 1/n)`, and one that took no part to `σ √(1 + 1/n)`.
#[test]
fn a_touch_without_what_it_helped_to_find_is_as_good_as_it_can_be() {
    // What noise tilts of the normals: squares of 1 µm over 25 mm.
    const TOL: f64 = 1e-7;
    let mut rng = ChaCha8Rng::seed_from_u64(72);
    let touches = directions(60)
        .iter()
        .map(|out| {
            let center = Point3::new(40.0, -20.0, 15.0) + out * (25.0 + TIP_MM - 0.02);
            let approach = Some(Unit::new_normalize(-out));
            BallTouch { approach, ..BallTouch::new(center + noise(SIGMA_MM, &mut rng), SIGMA_MM) }
        })
        .collect();
    let mut touches = measured(touches);
    touches.iter_mut().step_by(10).for_each(|touch| touch.role = Role::Check);
    let (fitted, checked) = (1, 0);
    let model = ProbeModel::new(setup(reference_sphere(Side::Along)), touches, &[]).unwrap();
    let closure = close_loop(&model, &model.all_covariates(), &Options::default()).unwrap();
    assert_eq!(closure.steps.len(), 1, "{:?}", closure.steps);
    for (index, sign) in [(fitted, -1.0), (checked, 1.0)] {
        let change = model.contact_change(index, &closure, [SIGMA_MM; 2]).unwrap();
        let expected = closure.variance_factor * SIGMA_MM.powi(2) * (1.0 + sign / 54.0);
        let found = change.sigma_deviation_mm.unwrap().powi(2);
        assert!((found / expected - 1.0).abs() < TOL, "touch {index}: {found:e} {expected:e}");
    }
}
