//! Probes qualified on a sphere or a ring.

use model_discrepancy::{Model, Options, State, close_loop};
use nalgebra::{Point3, Unit, Vector3};
use probe_comp::{
    BallTouch, NormalSource, ProbeError, ProbeTerms, Qualification, Reference, compensate, qualify,
};
use probe_comp::{ProbeModel, ProbeSetup, Side};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::scene::{
    TIP_MM, bowl, bowl_height, directions, measured, noise, normal_of, point_of, reference_sphere,
    setup,
};

const SIGMA_MM: f64 = 1e-3;
/// What the probe of these tests adds.
const PRETRAVEL_MM: f64 = 0.011;
const LOBES_MM: [f64; 2] = [0.004, -0.003];
const BENDING_MM: f64 = 0.006;
const SPHERE: Reference = Reference::Sphere { radius_mm: 12.5 };

/// Reading of a ball whose centre is at `center` when it touches, approached along `approach`.
fn read(center: Point3<f64>, approach: Vector3<f64>) -> Point3<f64> {
    let azimuth = 3.0 * approach.y.atan2(approach.x);
    let side = approach.xy().norm();
    let travel = PRETRAVEL_MM + side * (LOBES_MM[0] * azimuth.cos() + LOBES_MM[1] * azimuth.sin());
    center + approach * travel + Vector3::new(approach.x, approach.y, 0.0) * BENDING_MM
}

fn on_sphere(n: u32, sigma_mm: f64, rng: &mut ChaCha8Rng) -> Vec<BallTouch> {
    let place = Point3::new(210.0, -75.0, 40.0);
    directions(n)
        .iter()
        .map(|u| {
            let center = read(place + u * (12.5 + TIP_MM), -u) + noise(sigma_mm, rng);
            BallTouch::new(center, SIGMA_MM)
        })
        .collect()
}

fn assert_near(found: &Qualification, times: f64) {
    let std = found.covariance_mm2.diagonal().map(|v| v.max(0.0).sqrt());
    let pairs = [
        (found.effective_radius_mm, TIP_MM - PRETRAVEL_MM, std[3]),
        (found.lobes[0].cos_mm, LOBES_MM[0], std[4]),
        (found.lobes[0].sin_mm, LOBES_MM[1], std[5]),
        (found.bending_mm, BENDING_MM, std[6]),
    ];
    for (value, truth, std) in pairs {
        // 1e-5 mm: terms of the second order, 10 µm squared over 15 mm, left in by the approach
        // being taken along the normal at the place first found.
        assert!((value - truth).abs() < times * std + 1e-5, "{value} {truth} ± {std}");
    }
}

#[test]
fn a_probe_on_a_sphere() {
    let mut rng = ChaCha8Rng::seed_from_u64(51);
    let touches = on_sphere(60, SIGMA_MM, &mut rng);
    let found = qualify(&touches, &SPHERE, &ProbeTerms::default()).unwrap();
    assert_near(&found, 4.0);
    let off = found.place_mm - Point3::new(210.0, -75.0, 40.0);
    for axis in 0..3 {
        let std = found.covariance_mm2[(axis, axis)].sqrt();
        assert!(off[axis].abs() < 4.0 * std, "{off} ± {std} along {axis}");
    }
    let pretravel_mm = found.pretravel_mm(TIP_MM);
    assert!((pretravel_mm + found.effective_radius_mm - TIP_MM).abs() < 1e-12);
    assert_eq!(found.degrees_of_freedom, 60 - 7);
    // 53 squares of unit normals: their mean is known to 19 %.
    let factor = found.variance_factor.unwrap();
    assert!((0.4..1.6).contains(&factor), "{factor}");
}

/// The qualified probe measures a part to the noise; the unqualified one is off by its errors.
#[test]
fn later_touches_are_as_good_as_the_noise() {
    let mut rng = ChaCha8Rng::seed_from_u64(52);
    let touches = on_sphere(200, 0.0, &mut rng);
    let probe = qualify(&touches, &SPHERE, &ProbeTerms::default()).unwrap();
    let part: Vec<BallTouch> = (0..40)
        .map(|i| {
            let (x, y) = (f64::from(i) - 20.0, f64::from(i * 7 % 40) - 20.0);
            let normal = normal_of(bowl_height, x, y);
            let center = read(point_of(bowl_height, x, y) + normal * TIP_MM, -normal);
            BallTouch::new(center, SIGMA_MM)
        })
        .collect();
    let worst = |touches: &[BallTouch], radius_mm| {
        let contacts = compensate(&bowl(), radius_mm, touches, NormalSource::Nominal).unwrap();
        contacts.iter().map(|c| c.deviation_mm.abs()).fold(0.0, f64::max)
    };
    assert!(worst(&part, TIP_MM) > 0.009);
    let corrected = probe.applied(&bowl(), &part).unwrap();
    let left = worst(&corrected, probe.effective_radius_mm);
    assert!(left < 2e-5, "{left}");
}

#[test]
fn a_ring_shows_radius_and_lobes_but_not_bending() {
    let axis = Vector3::z_axis();
    let ring = Reference::Ring { radius_mm: 25.0, axis };
    let touches: Vec<BallTouch> = (0..24)
        .map(|i| {
            let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 24.0).sin_cos();
            let out = Vector3::new(cos, sin, 0.0);
            let center = Point3::new(5.0, 6.0, -2.0) + out * (25.0 - TIP_MM);
            BallTouch {
                approach: Some(Unit::new_normalize(out)),
                ..BallTouch::new(read(center, out), SIGMA_MM)
            }
        })
        .collect();
    let terms = ProbeTerms { bending: false, ..ProbeTerms::default() };
    let found = qualify(&touches, &ring, &terms).unwrap();
    // At right angles to the stylus, what bends is travel too.
    assert!((found.effective_radius_mm - (TIP_MM - PRETRAVEL_MM - BENDING_MM)).abs() < 1e-6);
    assert!((found.lobes[0].cos_mm - LOBES_MM[0]).abs() < 1e-6, "{:?}", found.lobes);
    assert!((found.lobes[0].sin_mm - LOBES_MM[1]).abs() < 1e-6, "{:?}", found.lobes);
    let error = qualify(&touches, &ring, &ProbeTerms::default()).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("bending") && text.contains("effective radius"), "{text}");
}

#[test]
fn what_cannot_be_qualified() {
    let mut rng = ChaCha8Rng::seed_from_u64(53);
    let touches = on_sphere(60, SIGMA_MM, &mut rng);
    let first = ProbeTerms { lobes: vec![1], ..ProbeTerms::default() };
    let error = qualify(&touches, &SPHERE, &first).unwrap_err();
    assert!(matches!(error, ProbeError::InvalidOption { name: "lobes", .. }), "{error}");
    let flat = Reference::Sphere { radius_mm: 0.0 };
    let error = qualify(&touches, &flat, &ProbeTerms::default()).unwrap_err();
    assert!(matches!(error, ProbeError::InvalidOption { name: "radius_mm", .. }), "{error}");
    for n in [0, 1, 5] {
        let error = qualify(&touches[..n], &SPHERE, &ProbeTerms::default()).unwrap_err();
        assert!(matches!(error, ProbeError::NotQualified { .. }), "{n}: {error}");
    }
    let bad = BallTouch::new(Point3::new(f64::NAN, 0.0, 0.0), SIGMA_MM);
    let error = qualify(&[bad], &SPHERE, &ProbeTerms::default()).unwrap_err();
    assert!(matches!(error, ProbeError::InvalidTouch { index: 0, .. }), "{error}");
}

/// Touches of a part that is as drawn, corrected with what so many touches of the artefact gave.
fn qualified_part(n_artefact: u32, rng: &mut ChaCha8Rng) -> (ProbeSetup, Vec<BallTouch>) {
    let artefact = on_sphere(n_artefact, SIGMA_MM, rng);
    let probe = qualify(&artefact, &SPHERE, &ProbeTerms::default()).unwrap();
    let nominal = reference_sphere(Side::Along);
    let middle = Point3::new(40.0, -20.0, 15.0);
    let read_part = |u: &Vector3<f64>| {
        let center = read(middle + u * (25.0 + TIP_MM), -u) + noise(SIGMA_MM, rng);
        BallTouch::new(center, SIGMA_MM)
    };
    let part: Vec<BallTouch> = directions(30).iter().map(read_part).collect();
    let touches = probe.applied(&nominal, &part).unwrap();
    // The touches' weights are their standard uncertainties.
    let qualification = Some(probe.uncertainty(1.0));
    let tip_radius_mm = probe.effective_radius_mm;
    (ProbeSetup { tip_radius_mm, qualification, ..setup(nominal) }, touches)
}

/// With 25 touches of the artefact the probe is known hardly better than the part's 30 touches show it.
#[test]
fn an_error_of_the_qualification_is_no_effect() {
    /// Of so many a binomial number with 5 % is above `MOST` once in a thousand times.
    const CASES: u64 = 40;
    const MOST: usize = 7;
    let named = |is_uncertain: bool| {
        let names_any = |seed: &u64| {
            let mut rng = ChaCha8Rng::seed_from_u64(9000 + seed);
            let (mut setup, touches) = qualified_part(25, &mut rng);
            if !is_uncertain {
                setup.qualification = None;
            }
            let model = ProbeModel::new(setup, measured(touches), &[]).unwrap();
            let closure = close_loop(&model, &model.all_covariates(), &Options::default()).unwrap();
            !closure.steps.is_empty()
        };
        (0..CASES).filter(names_any).count()
    };
    let (with, without) = (named(true), named(false));
    assert!(with <= MOST, "{with} of {CASES}");
    assert!(without > MOST, "{without} of {CASES}: the test shows nothing");
}

/// A radius that is larger by δ lowers every deviation by as much, and the prior knows by how many of
/// its standard uncertainties it is.
#[test]
fn the_radius_of_a_qualified_probe_has_rows_of_its_own() {
    const DELTA_MM: f64 = 1e-3;
    let mut rng = ChaCha8Rng::seed_from_u64(77);
    let (setup, touches) = qualified_part(25, &mut rng);
    let covariance = setup.qualification.as_ref().unwrap().covariance_mm2.clone();
    let larger = ProbeSetup { tip_radius_mm: setup.tip_radius_mm + DELTA_MM, ..setup.clone() };
    let [model, larger] =
        [setup, larger].map(|s| ProbeModel::new(s, measured(touches.clone()), &[]).unwrap());
    let n = touches.len();
    let mut at = State::start(&model);
    at.base[0] = DELTA_MM;
    let (moved, expected) = (model.residuals(&at), larger.residuals(&State::start(&larger)));
    for i in 0..n {
        // The foot of another ball lies elsewhere on a sphere by rounding alone.
        assert!((moved[i] - expected[i]).abs() < 1e-12, "{i}: {} {}", moved[i], expected[i]);
    }
    let prior = moved.rows_range(n..).norm_squared();
    let inverse = covariance.try_inverse().unwrap();
    assert!((prior - DELTA_MM * DELTA_MM * inverse[(0, 0)]).abs() < 1e-9 * prior, "{prior}");
}

#[test]
fn an_uncertainty_of_the_wrong_shape_is_refused() {
    let mut rng = ChaCha8Rng::seed_from_u64(78);
    let (mut setup, touches) = qualified_part(25, &mut rng);
    let known = setup.qualification.as_mut().unwrap();
    known.covariance_mm2 = known.covariance_mm2.view((0, 0), (2, 2)).into_owned();
    let refused = ProbeModel::new(setup, measured(touches), &[]).unwrap_err();
    assert!(
        matches!(refused, ProbeError::InvalidOption { name: "qualification", .. }),
        "{refused}"
    );
}

/// What is known of the artefact's touches scales what is known of the probe; taken as they are, it is
/// the covariance that the qualification has itself.
#[test]
fn a_probe_is_as_uncertain_as_the_touches_that_qualified_it() {
    let mut rng = ChaCha8Rng::seed_from_u64(56);
    let touches = on_sphere(60, 2.0 * SIGMA_MM, &mut rng);
    let found = qualify(&touches, &SPHERE, &ProbeTerms::default()).unwrap();
    let factor = found.variance_factor.unwrap();
    // Radius, two of the lobes and bending, without the three of the place.
    let own = found.covariance_mm2.view((3, 3), (4, 4)).into_owned();
    for times in [1.0, 0.3, 7.0] {
        let uncertain = found.uncertainty(times * factor).covariance_mm2;
        let off = (uncertain - &own * times).amax();
        assert!(off < 1e-14 * times * own.amax(), "{times}: {off:e}");
    }
}
