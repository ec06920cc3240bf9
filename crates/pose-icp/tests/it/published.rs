//! The method of document [D], its counts, and its experiment beside the exact pose.

use geometry::AsphereShape;
use nalgebra::Vector3;
use pose_icp::{
    Patch, PoseError, PoseOptions, PoseStart, SampledMethod, SampledOptions, Touch, fit_pose,
    fit_pose_on_samples, height_at, measuring_points, optimal_ratio,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::machine_scene::{Experiment, check_points, experiment};
use crate::pose_scene::{
    DIAMETER_MM, RADIUS_MM, TIP_MM, center_over, nine_points, paraboloid, tip, touches,
};

fn shape() -> AsphereShape {
    AsphereShape::on_axis(RADIUS_MM, -1.0, vec![], DIAMETER_MM)
}

/// Two levels at the ratio with the fewest points for 1 µm.
fn at_optimum() -> SampledOptions {
    let patch = Patch::OneSpacing;
    let coarse_mm = 1e-3 * optimal_ratio(DIAMETER_MM, 9, patch, 1e-3);
    let method = SampledMethod::TwoLevel { coarse_mm, fine_mm: 1e-3, patch };
    SampledOptions { method, tip: tip(), ..SampledOptions::default() }
}

#[test]
fn counts_and_optimum_are_those_of_the_document() {
    // «31 415.93 × 10⁴ points» at 5 µm.
    let classical = SampledMethod::Classical { spacing_mm: 5e-3 };
    let [points] = classical.predicted_points(100.0, 9)[..] else { panic!("one level") };
    assert!((points - 31_415.93e4).abs() < 0.01e4, "{points}");
    // 24 bytes each; the document's machine had 8 GB for everything.
    assert!((classical.predicted_bytes(100.0, 9) / 7.54e9 - 1.0).abs() < 1e-3);
    let two = |patch| SampledMethod::TwoLevel { coarse_mm: 1.0, fine_mm: 1e-3, patch };
    for (patch, second, ratio) in
        [(Patch::OneSpacing, 9e6, 172.0), (Patch::TwoSpacings, 36e6, 122.0)]
    {
        let points = two(patch).predicted_points(100.0, 9);
        assert!((points[0] - 7853.98).abs() < 0.01 && (points[1] / second - 1.0).abs() < 1e-12);
        let optimum = optimal_ratio(100.0, 9, patch, 1e-3);
        assert!((optimum - ratio).abs() < 0.5, "{optimum}");
        let total = |ratio: f64| {
            let method = SampledMethod::TwoLevel { coarse_mm: 1e-3 * ratio, fine_mm: 1e-3, patch };
            method.predicted_points(100.0, 9).iter().sum::<f64>()
        };
        assert!(total(optimum) < total(0.99 * optimum) && total(optimum) < total(1.01 * optimum));
    }
}

#[test]
fn the_touches_are_where_the_document_puts_them() {
    let found = measuring_points(DIAMETER_MM, 0.8);
    for (found, expected) in found.iter().zip(nine_points()) {
        assert!((found.coords - nalgebra::Vector2::from(expected)).norm() < 1e-12);
    }
}

#[test]
fn the_sampled_model_has_as_many_points_as_predicted() {
    let mut rng = ChaCha8Rng::seed_from_u64(431);
    let Experiment { touches, side, .. } = experiment(&mut rng);
    let options = at_optimum();
    let fit = fit_pose_on_samples(&shape(), &touches, &side.start, &options).unwrap();
    let predicted = options.method.predicted_points(DIAMETER_MM, touches.len());
    for (level, predicted) in fit.levels.iter().zip(predicted) {
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let ratio = level.model_points as f64 / predicted;
        // The rim cuts through cells, and a patch has a whole number of them.
        assert!((ratio - 1.0).abs() < 0.01, "{level:?} for {predicted}");
    }
}

/// Every touch ends within `δ_set` of the model, and heights are about as good as that; γ, which
/// nothing holds, stays where it started.
#[test]
fn both_levels_bring_the_touches_to_the_model() {
    let mut rng = ChaCha8Rng::seed_from_u64(432);
    for _ in 0..3 {
        let Experiment { pose, touches, side } = experiment(&mut rng);
        let classical = SampledMethod::Classical { spacing_mm: 0.5 };
        let coarse = SampledOptions { method: classical, tolerance_mm: 0.4, ..at_optimum() };
        for (options, height_mm) in [(at_optimum(), 9e-3), (coarse, 0.4)] {
            let fit = fit_pose_on_samples(&shape(), &touches, &side.start, &options).unwrap();
            assert!(fit.distances_mm.iter().all(|d| *d < options.tolerance_mm));
            assert!(fit.pose.angles.gamma_rad.abs() < 1e-3, "{:?}", fit.pose);
            for [x, y] in check_points() {
                let off = fit.machine_from_workpiece.inverse() * center_over(&pose, x, y, TIP_MM);
                let foot = paraboloid().surface().closest_point(&off).unwrap();
                assert!((foot.signed_distance_mm - TIP_MM).abs() < height_mm);
            }
        }
    }
}

#[test]
fn a_model_too_fine_for_the_memory_is_refused_with_its_size() {
    let mut rng = ChaCha8Rng::seed_from_u64(433);
    let Experiment { touches, side, .. } = experiment(&mut rng);
    let method = SampledMethod::Classical { spacing_mm: 5e-3 };
    let options = SampledOptions { method, ..SampledOptions::default() };
    let error = fit_pose_on_samples(&shape(), &touches, &side.start, &options).unwrap_err();
    assert!(matches!(error, PoseError::TooManyModelPoints { points, .. } if points > 3.1e8));
    assert!(error.to_string().contains("3.142e8 points, 7.5 GB"), "{error}");
}

#[test]
fn bad_input_is_refused_and_a_start_far_off_does_not_settle() {
    let mut rng = ChaCha8Rng::seed_from_u64(434);
    let Experiment { touches, side, .. } = experiment(&mut rng);
    let run = |touches: &[Touch], start: &PoseStart, options: &SampledOptions| {
        fit_pose_on_samples(&shape(), touches, start, options).unwrap_err()
    };
    let few = run(&touches[..5], &side.start, &at_optimum());
    assert!(matches!(few, PoseError::TooFewTouches { got: 5, parameters: 6, .. }), "{few}");
    for spacing_mm in [0.0, -1.0, f64::NAN] {
        let method = SampledMethod::Classical { spacing_mm };
        let error = run(&touches, &side.start, &SampledOptions { method, ..at_optimum() });
        assert!(matches!(error, PoseError::InvalidOption { .. }), "{error}");
    }
    let mut nan = touches.clone();
    nan[3].center_mm.x = f64::NAN;
    let error = run(&nan, &side.start, &at_optimum());
    assert!(matches!(error, PoseError::InvalidTouch { index: 3, .. }), "{error}");
    let beside = PoseStart::level(side.start.position_mm + Vector3::new(300.0, 0.0, 0.0), 0.0);
    let error = run(&touches, &beside, &SampledOptions { max_iterations: 3, ..at_optimum() });
    assert!(matches!(error, PoseError::NotConverged { .. }), "{error}");
}

/// A thousand poses with the errors of the document's machine: heights at its check points, and
/// what is said of them.
#[test]
fn the_documents_machine_gives_heights_to_two_micrometres() {
    let mut rng = ChaCha8Rng::seed_from_u64(435);
    let part = paraboloid();
    let (mut errors, mut inside) = (Vec::new(), 0);
    for _ in 0..1_000 {
        let Experiment { pose, touches, side } = experiment(&mut rng);
        let options =
            PoseOptions { tip: tip(), lateral: Some(side.prior), ..PoseOptions::default() };
        let fit = fit_pose(&part, &touches, &side.start, &options).unwrap();
        for [x, y] in check_points() {
            let at = center_over(&pose, x, y, TIP_MM);
            let height = height_at(&part, &fit, tip(), at.x, at.y, at.z).unwrap();
            let error_mm = (height.z_mm - at.z).abs();
            inside += usize::from(error_mm < 1.96 * height.sigma_mm.unwrap());
            errors.push(error_mm);
        }
    }
    errors.sort_by(f64::total_cmp);
    let n = errors.len();
    let p99_mm = errors[n * 99 / 100];
    // The document gives 9 µm.
    assert!(p99_mm < 2e-3, "99 % within {p99_mm} mm");
    assert!((93 * n..=97 * n).contains(&(100 * inside)), "{inside} of {n} in the 95 % band");
}

/// The document's loop of two levels on touches without noise: the pose hardly matters, heights do.
#[test]
fn without_noise_the_exact_pose_is_a_thousand_times_better() {
    let mut rng = ChaCha8Rng::seed_from_u64(436);
    let Experiment { pose, side, .. } = experiment(&mut rng);
    let exact = touches(&pose, &nine_points(), 0.0, &mut rng);
    let sampled = fit_pose_on_samples(&shape(), &exact, &side.start, &at_optimum()).unwrap();
    let options = PoseOptions { tip: tip(), ..PoseOptions::default() };
    let fit = fit_pose(&paraboloid(), &exact, &side.start, &options).unwrap();
    let worst = |residuals: &[f64]| residuals.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
    assert!(worst(&fit.residuals_mm) < 1e-3 * worst(&sampled.distances_mm));
}
