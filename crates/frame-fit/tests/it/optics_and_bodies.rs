//! Distortions of a planar image, and sub-assemblies that moved: named from data, by their size.

use frame_fit::{FrameModel, MeasuredPoint, Options, PointPair, Transform};
use model_discrepancy::{Closure, Effect, Model, State, Verdict, close_loop};
use nalgebra::{Point, Point2, Point3, SVector, Vector2, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::scene;

const SIGMA_MM: f64 = 0.01;

/// 49 spots on a plane, displaced by `distorted` before a similarity.
fn image(seed: u64, distorted: impl Fn(Vector2<f64>) -> Vector2<f64>) -> Closure {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let truth = scene::random_map::<2>(&mut rng, Transform::Similarity);
    let points: Vec<MeasuredPoint<2>> = scene::cloud::<2>(&mut rng, 49, 200.0)
        .into_iter()
        .enumerate()
        .map(|(i, source)| {
            let at = Point2::from(source.coords + distorted(source.coords));
            let noise = scene::gauss::<2>(&mut rng) * SIGMA_MM;
            let pair = PointPair::isotropic(source, truth.apply(&at) + noise, SIGMA_MM);
            MeasuredPoint::new(format!("S{i}"), pair)
        })
        .collect();
    let model = FrameModel::new(points, &[], &Options::of(Transform::Similarity)).unwrap();
    close_loop(&model, &model.coordinates(), &model_discrepancy::Options::default()).unwrap()
}

fn first_step(closure: &Closure) -> &str {
    closure.steps.first().map_or("nothing", |s| s.effect.as_str())
}

#[test]
fn a_lens_is_named() {
    // 0.3 mm at the corner, 200 mm from the centre.
    let closure = image(41, |x| x * (3.75e-8 * x.norm_squared()));
    assert_eq!(first_step(&closure), "lens-distortion");
    assert_eq!(closure.verdict, Verdict::Explained, "{:?}", closure.remaining);
    let k1 = &closure.steps[0].parameters[0];
    // The scale of the map takes up what the distortion does on the average: the ratio is free.
    assert!(k1.value > 10.0 * k1.std, "{k1:?}");
}

#[test]
fn a_tilted_image_is_named() {
    let closure = image(42, |x| x * (4e-6 * x.x - 3e-6 * x.y));
    assert_eq!(first_step(&closure), "perspective");
    assert_eq!(closure.verdict, Verdict::Explained, "{:?}", closure.remaining);
}

#[test]
fn a_smooth_field_is_a_polynomial() {
    let closure =
        image(43, |x| Vector2::new(5e-8 * x.y.powi(3), 4e-8 * x.x.powi(3) - 6e-6 * x.x * x.y));
    assert_eq!(first_step(&closure), "polynomial-distortion");
}

/// Three groups of seven targets; the second group turned and the third shifted.
#[test]
fn a_body_that_moved_is_named_and_measured() {
    let mut rng = ChaCha8Rng::seed_from_u64(44);
    let truth = scene::random_map::<3>(&mut rng, Transform::Rigid);
    let turn = Vector3::new(0.0, 1e-3, 0.0);
    let shift = Vector3::new(0.0, 0.2, -0.1);
    let moved = |body: usize, source: &Vector3<f64>| match body {
        1 => turn.cross(source),
        2 => shift,
        _ => Vector3::zeros(),
    };
    let points: Vec<MeasuredPoint<3>> = scene::cloud::<3>(&mut rng, 21, 300.0)
        .into_iter()
        .enumerate()
        .map(|(i, source)| {
            let body = i % 3;
            let at = Point3::from(source.coords + moved(body, &source.coords));
            let noise = scene::gauss::<3>(&mut rng) * SIGMA_MM;
            let pair = PointPair::isotropic(source, truth.apply(&at) + noise, SIGMA_MM);
            let point = MeasuredPoint::new(format!("T{i}"), pair);
            MeasuredPoint { body: Some(format!("B{body}")), ..point }
        })
        .collect();
    let model = FrameModel::new(points, &[], &Options::of(Transform::Rigid)).unwrap();
    let closure =
        close_loop(&model, &model.coordinates(), &model_discrepancy::Options::default()).unwrap();
    assert_eq!(first_step(&closure), "sub-assembly");
    assert_eq!(closure.verdict, Verdict::Explained, "{:?}", closure.remaining);
    let find = |name: &str| closure.steps[0].parameters.iter().find(|p| p.name == name).unwrap();
    // Against the first body; a turn about y is one from z towards x.
    for (name, truth) in [("B1 x to z", -1000.0), ("B2 y", 0.2), ("B2 z", -0.1)] {
        let found = find(name);
        assert!((found.value - truth).abs() < 4.0 * found.std, "{found:?}, truth {truth}");
    }
}

/// By how much every point is predicted further along with these amplitudes, in report units.
fn moves<const D: usize>(
    model: &FrameModel<D>,
    (id, subject): (&str, Option<&str>),
    reported: &[f64],
) -> Vec<SVector<f64, D>> {
    let effects = &model.declared().effects;
    let is_it = |e: &Effect| e.id == id && (subject.is_none() || e.subject.as_deref() == subject);
    let effect = effects.iter().position(is_it).unwrap();
    assert_eq!(reported.len(), effects[effect].parameters.len());
    let mut state = State::start(model);
    for (k, value) in reported.iter().enumerate() {
        state.amplitudes[effect][k] = value / effects[effect].parameters[k].report_factor;
    }
    let change = model.residuals(&State::start(model)) - model.residuals(&state);
    change.as_slice().chunks(D).map(SVector::from_column_slice).collect()
}

/// A dozen roundings of places of 200 mm.
const EXACT_TOL_MM: f64 = 1e-11;

/// Points where they are, in frames that are one; their centroid is off the origin.
fn in_place<const D: usize>(seed: u64, count: usize) -> (FrameModel<D>, Vec<SVector<f64, D>>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let points: Vec<_> = scene::cloud::<D>(&mut rng, count, 200.0)
        .into_iter()
        .map(|p| p + SVector::from_fn(|k, _| 30.0 - 50.0 * k as f64))
        .collect();
    let measured = |(k, p): (usize, &Point<f64, D>)| MeasuredPoint {
        body: Some(format!("B{}", k % 4)),
        ..MeasuredPoint::new(format!("S{k}"), PointPair::isotropic(*p, *p, SIGMA_MM))
    };
    let measured = points.iter().enumerate().map(measured).collect();
    let model = FrameModel::new(measured, &[], &Options::of(Transform::None)).unwrap();
    (model, points.iter().map(|p| p.coords).collect())
}

/// Brown's lens, a tilted image and monomials, against their formulas about the centroid.
#[test]
fn distortions_do_what_their_names_say() {
    let (model, places) = in_place::<2>(45, 60);
    let centroid = places.iter().sum::<Vector2<f64>>() / 60.0;
    let square = places.iter().map(|p| (p - centroid).norm_squared()).sum::<f64>();
    let reach_mm = (square / 60.0).sqrt();
    let assert_moves =
        |of: (&str, Option<&str>), reported: &[f64], expected: &dyn Fn(f64, f64) -> [f64; 2]| {
            for (found, place) in moves(&model, of, reported).iter().zip(&places) {
                let at = place - centroid;
                let off = found - Vector2::from(expected(at.x, at.y));
                assert!(off.norm() < EXACT_TOL_MM, "{of:?} at {at}: {off}");
            }
        };
    // 1 /m² is 1e-6 /mm², and 1 /m is 1e-3 /mm.
    assert_moves(("lens-distortion", None), &[0.04, 0.02, -0.03], &|x, y| {
        let (r2, k1, p1, p2) = (x * x + y * y, 4e-8, 2e-5, -3e-5);
        [
            x * k1 * r2 + p1 * (r2 + 2.0 * x * x) + p2 * 2.0 * x * y,
            y * k1 * r2 + p1 * 2.0 * x * y + p2 * (r2 + 2.0 * y * y),
        ]
    });
    assert_moves(("perspective", None), &[0.004, -0.003], &|x, y| {
        [x * (4e-6 * x - 3e-6 * y), y * (4e-6 * x - 3e-6 * y)]
    });
    // x², xy, y², x³, x²y, xy², y³ of x, then of y.
    let amplitudes: Vec<f64> = (1..=14).map(|k| 0.01 * f64::from(k)).collect();
    assert_moves(("polynomial-distortion", Some("degree 3")), &amplitudes, &|x, y| {
        let (u, v) = (x / reach_mm, y / reach_mm);
        let terms = [u * u, u * v, v * v, u * u * u, u * u * v, u * v * v, v * v * v];
        let sum = |first: usize| (0..7).map(|k| amplitudes[first + k] * terms[k]).sum();
        [sum(0), sum(7)]
    });
}

/// Each body moves about its own middle, and the one with most points, the first of them, stays.
#[test]
fn bodies_move_as_their_parameters_say() {
    let (model, places) = in_place::<3>(46, 14);
    // Shifts in mm, then turns from x to y, from x to z and from y to z in µrad; of B1, B2 and B3.
    let amplitudes: Vec<f64> = (1..=18).map(|k| 0.1 * f64::from(k)).collect();
    let middle = |body: usize| {
        let own: Vec<_> = places.iter().skip(body).step_by(4).collect();
        own.iter().copied().sum::<Vector3<f64>>() / own.len() as f64
    };
    let found = moves(&model, ("sub-assembly", None), &amplitudes);
    for (k, (found, place)) in found.iter().zip(&places).enumerate() {
        let body = k % 4;
        let mut expected = Vector3::zeros();
        if body > 0 {
            let of = &amplitudes[6 * (body - 1)..];
            let arm = place - middle(body);
            // From x to z is the wrong way round y.
            let turn = Vector3::new(of[5], -of[4], of[3]) * 1e-6;
            expected = Vector3::new(of[0], of[1], of[2]) + turn.cross(&arm);
        }
        assert!((found - expected).norm() < EXACT_TOL_MM, "point {k}: {found} {expected}");
    }
}
