//! Baarda's data snooping.

use frame_fit::{
    FrameMap, Noise, Options, PointPair, SnoopingOptions, Transform, Uncertainty, fit_frame,
    reliability, snoop,
};
use nalgebra::SVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::scene;

fn noisy_set(rng: &mut ChaCha8Rng, n: usize) -> Vec<PointPair<3>> {
    let truth = scene::random_map::<3>(rng, Transform::Rigid);
    let points = scene::cloud(rng, n, 200.0);
    let mut pairs = scene::exact(&points, &truth, Uncertainty::Isotropic { sigma_mm: 0.01 });
    for pair in &mut pairs {
        pair.uncertainty = scene::random_uncertainty(rng, 0.01);
    }
    scene::disturb(rng, &mut pairs);
    pairs
}

/// Any alarm in a clean set of ten: the 5 % asked for, within four standard deviations of 1000
/// trials. Points of one fit are nearly independent, so the sharing loses little.
#[test]
fn false_alarms_are_as_rare_as_asked() {
    const TRIALS: u32 = 1000;
    const BOUND: f64 = 4.0 * 0.0069;
    for noise in [Noise::Declared, Noise::Estimated] {
        let mut rng = ChaCha8Rng::seed_from_u64(51);
        let options = Options { noise, ..Options::default() };
        let mut alarms = 0;
        for _ in 0..TRIALS {
            let pairs = noisy_set(&mut rng, 10);
            let found = snoop(&pairs, &options, &SnoopingOptions::default()).unwrap();
            alarms += u32::from(!found.suspects.is_empty());
        }
        let share = f64::from(alarms) / f64::from(TRIALS);
        assert!((share - 0.05).abs() < BOUND, "{noise:?}: {share}");
    }
}

/// A bias of the detectable size, along any axis of any point, is found with the stated power:
/// 80 % within four standard deviations of 1000 trials.
#[test]
fn a_detectable_bias_is_detected_as_often_as_stated() {
    const TRIALS: u32 = 1000;
    const BOUND: f64 = 4.0 * 0.0126;
    for noise in [Noise::Declared, Noise::Estimated] {
        let mut rng = ChaCha8Rng::seed_from_u64(52);
        let options = Options { noise, ..Options::default() };
        let snooping = SnoopingOptions::default();
        let critical_p = 1.0 - 0.95_f64.powf(1.0 / 10.0);
        let mut found = 0;
        for _ in 0..TRIALS {
            let mut pairs = noisy_set(&mut rng, 10);
            let (point, axis) = (rng.random_range(0..10), rng.random_range(0..3));
            // The size depends on the design and the true noise, not on this noise.
            let fit = fit_frame(&pairs, &Options::default()).unwrap();
            let declared = reliability(&pairs, &fit, &snooping).unwrap();
            let mut size_mm = declared[point].detectable_mm[axis];
            if noise == Noise::Estimated {
                let fit = fit_frame(&pairs, &options).unwrap();
                let estimated = reliability(&pairs, &fit, &snooping).unwrap();
                size_mm =
                    estimated[point].detectable_mm[axis] / fit.variance_factor.unwrap().sqrt();
            }
            pairs[point].target_mm[axis] += size_mm;
            let fit = fit_frame(&pairs, &options).unwrap();
            let judged = reliability(&pairs, &fit, &snooping).unwrap();
            found += u32::from(judged[point].p_value < critical_p);
        }
        let share = f64::from(found) / f64::from(TRIALS);
        assert!((share - 0.8).abs() < BOUND, "{noise:?}: {share}");
    }
}

#[test]
fn gross_errors_are_named_with_their_size() {
    for noise in [Noise::Declared, Noise::Estimated] {
        let mut rng = ChaCha8Rng::seed_from_u64(53);
        let options = Options { noise, ..Options::default() };
        for _ in 0..50 {
            let mut pairs = noisy_set(&mut rng, 12);
            let biases =
                [(3, SVector::from([0.0, 0.9, 0.0])), (7, SVector::from([-0.5, 0.0, 0.4]))];
            for (point, bias) in biases {
                pairs[point].target_mm += bias;
            }
            let found = snoop(&pairs, &options, &SnoopingOptions::default()).unwrap();
            let mut named: Vec<_> = found.suspects.iter().map(|s| s.index).collect();
            named.sort_unstable();
            assert!(named.contains(&3) && named.contains(&7), "{named:?}");
            for suspect in found.suspects.iter().filter(|s| s.index == 3) {
                // Noise of about 15 µm in the point and as much in the frame there.
                assert!((suspect.bias_mm - biases[0].1).norm() < 0.15, "{}", suspect.bias_mm);
            }
            assert!(!found.kept.contains(&3) && !found.kept.contains(&7));
            assert_eq!(found.reliability.len(), found.kept.len());
        }
    }
}

/// One gross error in a small set, at any size: every other point is contradicted beyond doubt
/// too, and still only one is bad.
#[test]
fn a_gross_error_does_not_take_others_with_it() {
    let mut rng = ChaCha8Rng::seed_from_u64(56);
    for size_mm in [1.0, 30.0, 1000.0] {
        let mut more = 0;
        for _ in 0..40 {
            let mut pairs = noisy_set(&mut rng, 9);
            pairs[4].target_mm.x += size_mm;
            let options = Options::of(Transform::Affine);
            let found = snoop(&pairs, &options, &SnoopingOptions::default()).unwrap();
            assert_eq!(found.suspects[0].index, 4, "{size_mm} mm");
            more += found.suspects.len() - 1;
        }
        // Each set raises another alarm with 5 %: 2 ± 1.4 of forty.
        assert!(more <= 8, "{more}");
    }
}

/// For uncorrelated coordinates the redundancy numbers add up to the degrees of freedom; the
/// bias they point to is what a refit without the point finds.
#[test]
fn redundancy_adds_up_and_the_bias_is_that_of_a_refit() {
    let mut rng = ChaCha8Rng::seed_from_u64(54);
    for transform in [Transform::Translation, Transform::Affine] {
        let truth = scene::random_map::<3>(&mut rng, transform);
        let points = scene::cloud(&mut rng, 9, 200.0);
        let sigma = Uncertainty::PerAxis { sigma_mm: SVector::from([0.01, 0.02, 0.05]) };
        let mut pairs = scene::exact(&points, &truth, sigma);
        scene::disturb(&mut rng, &mut pairs);
        let options = Options::of(transform);
        let fit = fit_frame(&pairs, &options).unwrap();
        let judged = reliability(&pairs, &fit, &SnoopingOptions::default()).unwrap();
        let sum: f64 = judged.iter().map(|r| r.redundancy.sum()).sum();
        assert!((sum - fit.degrees_of_freedom as f64).abs() < 1e-9, "{sum}");
        for (k, judged) in judged.iter().enumerate() {
            let mut others = pairs.clone();
            let left_out = others.remove(k);
            let refit = fit_frame(&others, &options).unwrap();
            // The families are linear here, so the two agree to round-off.
            let bias = refit.residual_mm(&left_out);
            assert!((judged.bias_mm.unwrap() - bias).norm() < 1e-9, "{bias}");
            let before = fit.variance_factor.unwrap() * fit.degrees_of_freedom as f64;
            let after = refit.variance_factor.unwrap() * refit.degrees_of_freedom as f64;
            assert!((judged.chi2_drop - (before - after)).abs() < 1e-7 * before);
        }
    }
}

/// Three points carry a spatial frame but not one another: nothing can be set aside.
#[test]
fn points_that_nobody_controls_stay() {
    let mut pairs: Vec<_> = [[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0]]
        .map(|p| PointPair::isotropic(p, p, 0.01))
        .to_vec();
    pairs[1].target_mm.x += 5.0;
    let found = snoop(&pairs, &Options::default(), &SnoopingOptions::default()).unwrap();
    assert!(found.suspects.is_empty());
    // Out of their plane they are free: z redundancy is nil, and any bias there is undetectable.
    for judged in &found.reliability {
        assert!(judged.redundancy.z < 1e-12 && judged.detectable_mm.z.is_infinite());
        assert!(judged.bias_mm.is_none());
    }
}

#[test]
fn exact_points_contradict_nobody() {
    let mut rng = ChaCha8Rng::seed_from_u64(55);
    for noise in [Noise::Declared, Noise::Estimated] {
        for _ in 0..50 {
            let truth: FrameMap<3> = scene::random_map(&mut rng, Transform::Rigid);
            let points = scene::cloud(&mut rng, 8, 200.0);
            let pairs = scene::exact(&points, &truth, Uncertainty::Isotropic { sigma_mm: 0.01 });
            let options = Options { noise, ..Options::default() };
            let found = snoop(&pairs, &options, &SnoopingOptions::default()).unwrap();
            assert!(found.suspects.is_empty(), "{noise:?} {:?}", found.suspects);
        }
    }
}
