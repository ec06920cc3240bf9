//! Distortions of a planar image, and sub-assemblies that moved: named from data, by their size.

use frame_fit::{FrameModel, MeasuredPoint, Options, PointPair, Transform};
use model_discrepancy::{Closure, Verdict, close_loop};
use nalgebra::{Point2, Point3, Vector2, Vector3};
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
