//! Do the stated uncertainties hold?

use frame_fit::{FrameFit, FrameMap, Noise, Options, PointPair, Transform, Uncertainty, fit_frame};
use nalgebra::{DVector, Point, SMatrix, SVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::scene;

const TRIALS: u32 = 2000;
/// Coverage asked of 95 % intervals; the standard deviation of 2000 trials is 0.5 %.
const COVERAGE: std::ops::RangeInclusive<f64> = 0.93..=0.97;

/// Parameters of the motion about the pivot that takes the fit to the truth, to first order.
fn error<const D: usize>(fit: &FrameFit<D>, truth: &FrameMap<D>) -> DVector<f64> {
    let motion = truth.after(&fit.target_from_source.inverse().unwrap());
    let shift = motion.apply(&fit.pivot_mm) - fit.pivot_mm;
    let strain = motion.linear - SMatrix::identity();
    let entries = fit.parameters().into_iter().map(|parameter| match parameter.name {
        "tx" => shift[0],
        "ty" => shift[1],
        "tz" => shift[2],
        "rx" => 0.5 * (strain[(2, 1)] - strain[(1, 2)]),
        "ry" => 0.5 * (strain[(0, 2)] - strain[(2, 0)]),
        "rz" => 0.5 * (strain[(1, 0)] - strain[(0, 1)]),
        "scale" => (0..D).map(|k| strain[(k, k)]).sum::<f64>() / D as f64,
        "scale_x" => strain[(0, 0)],
        "scale_y" => strain[(1, 1)],
        "scale_z" => strain[(2, 2)],
        "shear_xy" => strain[(0, 1)] + strain[(1, 0)],
        "shear_xz" => strain[(0, 2)] + strain[(2, 0)],
        "shear_yz" => strain[(1, 2)] + strain[(2, 1)],
        other => panic!("unknown parameter {other}"),
    });
    DVector::from_vec(entries.collect())
}

/// Simulated fits; `stated` is by how much the stated uncertainties are too large.
fn simulate<const D: usize>(
    seed: u64,
    n: usize,
    options: &Options,
    stated: f64,
    mut judge: impl FnMut(&FrameFit<D>, &FrameMap<D>),
) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for _ in 0..TRIALS {
        let truth = scene::random_map::<D>(&mut rng, options.transform);
        let points = scene::cloud(&mut rng, n, 300.0);
        let mut pairs = scene::exact(&points, &truth, Uncertainty::Isotropic { sigma_mm: 1.0 });
        for pair in &mut pairs {
            pair.uncertainty = scene::random_uncertainty(&mut rng, 0.02);
        }
        scene::disturb(&mut rng, &mut pairs);
        for pair in &mut pairs {
            let covariance_mm2 = pair.uncertainty.covariance_mm2() * stated.powi(2);
            pair.uncertainty = Uncertainty::Full { covariance_mm2 };
        }
        judge(&fit_frame(&pairs, options).unwrap(), &truth);
    }
}

fn assert_coverage<const D: usize>(seed: u64, n: usize, options: &Options, stated: f64) {
    let count = options.transform.parameter_count(D);
    let mut covered = vec![0; count];
    simulate::<D>(seed, n, options, stated, |fit, truth| {
        let half_widths = fit.half_widths(0.95).unwrap();
        let error = error(fit, truth);
        for k in 0..count {
            covered[k] += u32::from(error[k].abs() <= half_widths[k]);
        }
    });
    for (k, covered) in covered.into_iter().enumerate() {
        let share = f64::from(covered) / f64::from(TRIALS);
        assert!(COVERAGE.contains(&share), "{} {D}-d parameter {k}: {share}", options.transform);
    }
}

const FITTED: [Transform; 4] =
    [Transform::Translation, Transform::Rigid, Transform::Similarity, Transform::Affine];

#[test]
fn intervals_cover_the_truth_when_the_noise_is_declared() {
    for transform in FITTED {
        let options = Options::of(transform);
        assert_coverage::<2>(1, 5, &options, 1.0);
        assert_coverage::<3>(2, 7, &options, 1.0);
    }
}

#[test]
fn intervals_cover_the_truth_when_the_noise_is_estimated() {
    for transform in FITTED {
        let options = Options { noise: Noise::Estimated, ..Options::of(transform) };
        // The smallest sets, where Student's t differs most from the normal distribution.
        assert_coverage::<2>(3, transform.minimum_points(2) + 1, &options, 7.0);
        assert_coverage::<3>(4, transform.minimum_points(3) + 1, &options, 7.0);
    }
}

/// Mean of the normalised squared error is the number of parameters, that of the variance
/// factor 1; the bounds are four of their own standard deviations.
#[test]
fn the_covariance_predicts_the_scatter() {
    for transform in FITTED {
        let (mut errors, mut factors, mut dof) = (0.0, 0.0, 0);
        simulate::<3>(5, 8, &Options::of(transform), 1.0, |fit, truth| {
            let error = error(fit, truth);
            errors += error.dot(&fit.covariance.clone().cholesky().unwrap().solve(&error));
            factors += fit.variance_factor.unwrap();
            dof = fit.degrees_of_freedom;
        });
        let trials = f64::from(TRIALS);
        let parameters = transform.parameter_count(3) as f64;
        let bound = 4.0 * (2.0 * parameters / trials).sqrt();
        let mean = errors / trials;
        assert!((mean - parameters).abs() < bound, "{transform}: {mean} for {parameters}");
        let bound = 4.0 * (2.0 / dof as f64 / trials).sqrt();
        let mean = factors / trials;
        assert!((mean - 1.0).abs() < bound, "{transform}: variance factor {mean}");
    }
}

/// The same for the image of a point outside the set.
#[test]
fn the_covariance_of_an_image_predicts_its_scatter() {
    let place = Point::from(SVector::<f64, 3>::new(500.0, -400.0, 300.0));
    let mut sum = 0.0;
    simulate::<3>(6, 6, &Options::default(), 1.0, |fit, truth| {
        let miss = truth.apply(&place) - fit.target_from_source.apply(&place);
        let covariance = fit.point_covariance_mm2(&place).unwrap();
        sum += miss.dot(&covariance.cholesky().unwrap().solve(&miss));
    });
    let mean = sum / f64::from(TRIALS);
    let bound = 4.0 * (6.0 / f64::from(TRIALS)).sqrt();
    assert!((mean - 3.0).abs() < bound, "{mean}");
}

/// Two-sided 95 % quantiles of Student's t, from printed tables, to all their digits.
#[test]
fn coverage_factors_are_those_of_the_tables() {
    // Planar translation of n points has 2 n − 2 degrees of freedom.
    for (n, table) in [(2, 4.302_65), (3, 2.776_45), (6, 2.228_14), (16, 2.042_27)] {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let points = scene::cloud::<2>(&mut rng, n, 100.0);
        let mut pairs: Vec<PointPair<2>> =
            scene::exact(&points, &FrameMap::identity(), Uncertainty::Isotropic { sigma_mm: 0.1 });
        scene::disturb(&mut rng, &mut pairs);
        let options = Options { noise: Noise::Estimated, ..Options::of(Transform::Translation) };
        let fit = fit_frame(&pairs, &options).unwrap();
        let factor = fit.half_widths(0.95).unwrap()[0] / fit.standard_uncertainties().unwrap()[0];
        assert!((factor - table).abs() < 5e-6, "{n} points: {factor}");
        let declared = fit_frame(&pairs, &Options::of(Transform::Translation)).unwrap();
        let normal =
            declared.half_widths(0.95).unwrap()[0] / declared.standard_uncertainties().unwrap()[0];
        assert!((normal - 1.959_963_985).abs() < 1e-9, "{normal}");
        assert!(declared.half_widths(1.0).is_none() && declared.half_widths(f64::NAN).is_none());
    }
}
