//! Robust losses against outliers.

use frame_fit::{FrameMap, Noise, Options, PointPair, Transform, Uncertainty, fit_frame};
use least_squares::Loss;
use nalgebra::SVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::scene;

/// Median misplacement of the corners of the volume, over 200 sets of 20 points of which 4 are
/// off by up to 5 mm; the noise is 10 µm.
fn median_miss_mm(loss: Option<Loss>, noise: Noise, outliers: usize) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(41);
    let options = Options { loss, noise, ..Options::of(Transform::Rigid) };
    let mut misses: Vec<f64> = (0..200)
        .map(|_| {
            let truth = scene::random_map::<3>(&mut rng, Transform::Rigid);
            let points = scene::cloud(&mut rng, 20, 200.0);
            let sigma = Uncertainty::Isotropic { sigma_mm: 0.01 };
            let mut pairs = scene::exact(&points, &truth, sigma);
            scene::disturb(&mut rng, &mut pairs);
            for pair in pairs.iter_mut().take(4) {
                let off = scene::uniform::<3>(&mut rng, 5.0);
                if outliers == 4 {
                    pair.target_mm += off;
                }
            }
            if noise == Noise::Estimated {
                restate(&mut pairs, rng.random_range(0.1..10.0));
            }
            let fit = fit_frame(&pairs, &options).unwrap();
            scene::map_distance_mm(&fit.target_from_source, &truth, 200.0)
        })
        .collect();
    misses.sort_by(f64::total_cmp);
    misses[misses.len() / 2]
}

fn restate(pairs: &mut [PointPair<3>], factor: f64) {
    for pair in pairs {
        pair.uncertainty = Uncertainty::Isotropic { sigma_mm: 0.01 * factor };
    }
}

#[test]
fn outliers_lose_their_hold() {
    for noise in [Noise::Declared, Noise::Estimated] {
        let clean = median_miss_mm(None, noise, 0);
        let spoilt = median_miss_mm(None, noise, 4);
        let huber = median_miss_mm(Some(Loss::Huber { scale: 2.0 }), noise, 4);
        let tukey = median_miss_mm(Some(Loss::Tukey { scale: 6.0 }), noise, 4);
        assert!(spoilt > 20.0 * clean, "plain squares: {spoilt} against {clean}");
        assert!(huber < 5.0 * clean, "Huber {huber} against {clean}");
        // Without the four points a set of sixteen is √(20/16) = 1.12 times worse.
        assert!(tukey < 1.3 * clean, "Tukey {tukey} against {clean}");
    }
}

#[test]
fn good_points_keep_their_weight() {
    let mut rng = ChaCha8Rng::seed_from_u64(42);
    let points = scene::cloud(&mut rng, 12, 200.0);
    let sigma = Uncertainty::Isotropic { sigma_mm: 0.01 };
    let mut pairs = scene::exact(&points, &FrameMap::<3>::identity(), sigma);
    scene::disturb(&mut rng, &mut pairs);
    pairs[5].target_mm += SVector::from([0.0, 2.0, 0.0]);
    let options = Options { loss: Some(Loss::Tukey { scale: 6.0 }), ..Options::default() };
    let fit = fit_frame(&pairs, &options).unwrap();
    for (k, weight) in fit.weights.iter().enumerate() {
        if k == 5 {
            assert!(*weight == 0.0);
            assert!((fit.residuals_mm[5].y - 2.0).abs() < 0.1);
        } else {
            assert!(*weight > 0.3, "point {k}: {weight}");
        }
    }
    let plain = fit_frame(&pairs, &Options::default()).unwrap();
    assert_eq!(plain.weights, [1.0; 12]);
}
