//! Does the scatter of the poses agree with the covariance that is claimed?

use geometry::se3;
use nalgebra::{Isometry3, Translation3};
use pose_icp::{CloudTarget, RegisterOptions, register_to_cloud};

use super::scene;

/// Noise along the normal, mm; far above what the sampling of the target adds.
const SIGMA_MM: f64 = 0.05;

/// Mean normalised squared error of six components: 6, with a standard deviation of √(12/N).
#[test]
fn covariance_predicts_the_scatter() {
    let trials = 300;
    let mut rng = scene::rng(20);
    let target = CloudTarget::new(&scene::target(&mut rng, 150)).unwrap();
    let (mut sum, mut variance) = (0.0, 0.0);
    for _ in 0..trials {
        let truth = scene::small_pose();
        let source = scene::source(&mut rng, 400, SIGMA_MM, &truth);
        let options = RegisterOptions { sigma_mm: Some(SIGMA_MM), ..Default::default() };
        let found = register_to_cloud(&source, &target, &options).unwrap();
        let pivot = Translation3::from(found.pivot_mm.coords);
        let about_pivot = |pose: &Isometry3<f64>| pivot.inverse() * pose;
        let error = se3::difference(&about_pivot(&found.target_from_source), &about_pivot(&truth));
        sum += error.dot(&found.covariance.cholesky().unwrap().solve(&error));
        variance += (found.rms_mm / SIGMA_MM).powi(2) * 400.0 / 394.0;
    }
    let n = f64::from(trials);
    let mean = sum / n;
    let bound = 4.0 * (12.0 / n).sqrt();
    assert!((mean - 6.0).abs() < bound, "mean normalised squared error {mean}, 6 ± {bound}");
    // χ²/dof with 394 · 300 degrees of freedom: σ = √(2/118200) = 0.4 %; the sampling of the
    // target adds (1 µm / 50 µm)².
    assert!((variance / n - 1.0).abs() < 0.02, "variance factor {}", variance / n);
}

/// Points of the target that are noisy themselves are averaged, and rows that share an average know
/// of it: the claimed covariance still holds, though it is that of fewer independent rows.
#[test]
fn covariance_predicts_the_scatter_on_a_noisy_target() {
    let trials = 200;
    let mut rng = scene::rng(22);
    let (mut sum, mut sigma) = (0.0, 0.0);
    for _ in 0..trials {
        let cloud = scene::noisy(&mut rng, scene::target(&mut scene::rng(23), 60), SIGMA_MM);
        let target = CloudTarget::new(&cloud).unwrap();
        let truth = scene::small_pose();
        let source = scene::source(&mut rng, 4000, SIGMA_MM, &truth);
        let found = register_to_cloud(&source, &target, &RegisterOptions::default()).unwrap();
        let pivot = Translation3::from(found.pivot_mm.coords);
        let about_pivot = |pose: &Isometry3<f64>| pivot.inverse() * pose;
        let error = se3::difference(&about_pivot(&found.target_from_source), &about_pivot(&truth));
        sum += error.dot(&found.covariance.cholesky().unwrap().solve(&error));
        sigma += found.sigma_mm / f64::from(trials);
    }
    let mean = sum / f64::from(trials);
    let bound = 4.0 * (12.0 / f64::from(trials)).sqrt();
    // Noise of the target is larger at the border of the averages than in their middle, and flips of
    // pairs add to it: the factor by which rows share it is good to a fifth.
    assert!((mean - 6.0).abs() < bound + 1.2, "mean normalised squared error {mean}");
    // Leaves have 3600/512 = 7 points: √(1 + 1/7) of the noise is left, where single points leave √2.
    let expected = SIGMA_MM * (8.0_f64 / 7.0).sqrt();
    assert!((sigma / expected - 1.0).abs() < 0.06, "sigma {sigma}, expected {expected}");
}

#[test]
fn an_estimated_sigma_is_the_one_of_the_noise() {
    let mut rng = scene::rng(21);
    let target = CloudTarget::new(&scene::target(&mut rng, 150)).unwrap();
    let source = scene::source(&mut rng, 20_000, SIGMA_MM, &scene::small_pose());
    let found = register_to_cloud(&source, &target, &RegisterOptions::default()).unwrap();
    // σ of a standard deviation from 2e4 residuals: 1/√(4e4) = 0.5 %; 4σ = 2 %.
    assert!((found.sigma_mm / SIGMA_MM - 1.0).abs() < 0.02, "sigma {} mm", found.sigma_mm);
    assert!((found.rms_mm / SIGMA_MM - 1.0).abs() < 0.02, "rms {} mm", found.rms_mm);
    assert_eq!(found.observability.unwrap().weak, vec![]);
}
