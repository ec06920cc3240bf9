//! Plain data goes to JSON and comes back the same.

use frame_fit::{FrameFit, Options, PointPair, Transform, Uncertainty, fit_frame};
use nalgebra::SVector;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::scene;

#[test]
fn pairs_options_and_fits_survive_a_file() {
    let mut rng = ChaCha8Rng::seed_from_u64(81);
    let truth = scene::random_map::<3>(&mut rng, Transform::Similarity);
    let points = scene::cloud(&mut rng, 6, 200.0);
    let sigma = Uncertainty::PerAxis { sigma_mm: SVector::from([0.01, 0.02, 0.03]) };
    let mut pairs = scene::exact(&points, &truth, sigma);
    scene::disturb(&mut rng, &mut pairs);
    let options = Options::of(Transform::Similarity);
    let fit = fit_frame(&pairs, &options).unwrap();

    let text = serde_json::to_string(&(&pairs, &options, &fit)).unwrap();
    let back: (Vec<PointPair<3>>, Options, FrameFit<3>) = serde_json::from_str(&text).unwrap();
    assert_eq!(back, (pairs, options, fit));
    assert!(text.contains("\"transform\":\"similarity\""), "{text}");
}
