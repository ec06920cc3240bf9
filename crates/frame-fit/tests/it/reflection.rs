//! Mirrored frames.

use frame_fit::{
    FrameFitError, Handedness, Noise, Options, PointPair, ReflectionVerdict, Transform,
    Uncertainty, fit_frame, shape_of,
};
use nalgebra::{Point, Point2, SVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::scene;

/// A sensor whose z opposes the machine's, seen in the plane: x is turned round. Three points on
/// a circle of 30 mm are missed by 30 √2 = 42 mm, the figure the specification quotes.
#[test]
fn a_proper_rotation_misses_a_mirrored_circle_by_42_mm() {
    let pairs = [0.0_f64, 120.0, 240.0].map(|degrees| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let source = Point2::new(30.0 * cos, 30.0 * sin);
        PointPair::isotropic(source, Point2::new(-source.x, source.y), 0.05)
    });
    // On a circle every rotation misses by the same, so that none can be named.
    let error = fit_frame(&pairs, &Options::default()).unwrap_err();
    let FrameFitError::Mirrored { rms_mm, other_rms_mm, .. } = error else { panic!("{error}") };
    assert!((rms_mm - 30.0 * 2.0_f64.sqrt()).abs() < 1e-9, "{rms_mm}");
    assert!(other_rms_mm < 1e-12);

    let options = Options { handedness: Handedness::Improper, ..Options::default() };
    let mirrored = fit_frame(&pairs, &options).unwrap();
    assert_eq!(mirrored.handedness, Handedness::Improper);
    assert!(mirrored.rms_mm() < 1e-12);
}

fn verdicts<const D: usize>(mirror: bool, flat: bool, noise: Noise) -> [u32; 3] {
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let mut counts = [0; 3];
    for transform in [Transform::Rigid, Transform::Similarity, Transform::Affine] {
        for _ in 0..200 {
            let family = if transform == Transform::Affine { Transform::Rigid } else { transform };
            let mut truth = scene::random_map::<D>(&mut rng, family);
            if mirror {
                truth.linear.column_mut(0).neg_mut();
            }
            let mut points = scene::cloud::<D>(&mut rng, 6, 300.0);
            if flat {
                // A plane askew, or a line.
                let normal = scene::gauss::<D>(&mut rng).normalize();
                for point in &mut points {
                    *point -= normal * normal.dot(&point.coords);
                }
            }
            let sigma =
                Uncertainty::PerAxis { sigma_mm: SVector::from_fn(|k, _| 0.1 / (1.0 + k as f64)) };
            let mut pairs = scene::exact(&points, &truth, sigma);
            scene::disturb(&mut rng, &mut pairs);
            let options = Options { noise, ..Options::of(transform) };
            let fit = match fit_frame(&pairs, &options) {
                Ok(fit) => fit,
                Err(_) if flat && transform == Transform::Affine => continue,
                // A mirror may leave no similarity but one that shrinks everything to a point.
                Err(FrameFitError::Mirrored { .. }) if mirror => {
                    counts[1] += 1;
                    continue;
                }
                Err(error) => panic!("{error}"),
            };
            match fit.reflection.unwrap().verdict {
                ReflectionVerdict::Proper => counts[0] += 1,
                ReflectionVerdict::Improper => counts[1] += 1,
                ReflectionVerdict::Undecided => counts[2] += 1,
            }
        }
    }
    counts
}

#[test]
fn a_mirror_is_seen_where_the_points_show_it() {
    for noise in [Noise::Declared, Noise::Estimated] {
        assert_eq!(verdicts::<2>(false, false, noise), [600, 0, 0]);
        assert_eq!(verdicts::<2>(true, false, noise), [0, 600, 0]);
        assert_eq!(verdicts::<3>(false, false, noise), [600, 0, 0]);
        assert_eq!(verdicts::<3>(true, false, noise), [0, 600, 0]);
    }
}

/// In a plane (planar: on a line) the two maps differ by noise alone; a verdict at a likelihood
/// ratio of 1000 is then wrong at most once in a thousand: four of 800 is beyond 4 σ.
#[test]
fn points_in_a_plane_leave_it_undecided() {
    for noise in [Noise::Declared, Noise::Estimated] {
        for mirror in [false, true] {
            let [proper, improper, undecided] = verdicts::<3>(mirror, true, noise);
            assert!(proper + improper <= 4 && undecided >= 396, "{proper} {improper}");
            let [proper, improper, undecided] = verdicts::<2>(mirror, true, noise);
            assert!(proper + improper <= 4 && undecided >= 396, "{proper} {improper}");
        }
    }
}

#[test]
fn an_improper_fit_is_as_exact_as_a_proper_one() {
    let mut rng = ChaCha8Rng::seed_from_u64(22);
    for transform in [Transform::Rigid, Transform::Similarity] {
        let mut truth = scene::random_map::<3>(&mut rng, transform);
        truth.linear.column_mut(2).neg_mut();
        let points = scene::cloud(&mut rng, 6, 300.0);
        let sigma = scene::random_uncertainty(&mut rng, 0.01);
        let pairs = scene::exact(&points, &truth, sigma);
        let options = Options { handedness: Handedness::Improper, ..Options::of(transform) };
        let fit = fit_frame(&pairs, &options).unwrap();
        assert!(scene::map_distance_mm(&fit.target_from_source, &truth, 300.0) < 1e-9);
        assert!(fit.target_from_source.isometry().is_none());
    }
}

/// The affine map finds the mirror by itself, and its shape says so.
#[test]
fn the_shape_of_an_affine_fit_names_the_mirror() {
    let corners = [[0.0, 0.0], [100.0, 0.0], [0.0, 80.0], [90.0, 70.0]];
    let pairs = corners.map(|c| {
        let source = Point::from(SVector::from(c));
        PointPair::isotropic(source, Point2::new(1.01 * c[1], c[0]), 0.01)
    });
    let fit = fit_frame(&pairs, &Options::of(Transform::Affine)).unwrap();
    let shape = shape_of(&fit.target_from_source);
    assert_eq!(shape.handedness, Handedness::Improper);
    assert!((shape.principal_scales - SVector::<f64, 2>::new(1.01, 1.0)).amax() < 1e-12);
    assert!((shape.axis_scales - SVector::<f64, 2>::new(1.0, 1.01)).amax() < 1e-12);
}

/// Round-off of two sums of squares and of the logarithm of their ratio.
const RATIO_TOL: f64 = 1e-9;

/// Points near a plane (planar: near a line), so that both maps fit and neither exactly.
fn nearly_flat<const D: usize>(rng: &mut ChaCha8Rng, sigma_mm: f64) -> Vec<PointPair<D>> {
    let truth = scene::random_map::<D>(rng, Transform::Rigid);
    let mut points = scene::cloud::<D>(rng, 7, 100.0);
    for point in &mut points {
        point[D - 1] *= 1e-3;
    }
    let mut pairs = scene::exact(&points, &truth, Uncertainty::Isotropic { sigma_mm });
    scene::disturb(rng, &mut pairs);
    pairs
}

/// The likelihood of normal residuals, from the two root mean squares alone: where the noise is
/// estimated, `σ⁻ᵈ` at the σ that each map leaves, over d degrees of freedom; where it is declared,
/// `exp(−χ²/2)`, at the larger of the declared noise and of what the better map leaves.
fn ratio_follows_from_the_distances<const D: usize>(seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (sigma_mm, n) = (0.05, 7.0);
    let pairs = nearly_flat::<D>(&mut rng, sigma_mm);
    // A pose has six unknowns, three in the plane; a similarity one more.
    for (transform, unknowns) in [(Transform::Rigid, 0), (Transform::Similarity, 1)] {
        let dof = (7 * D - D * (D + 1) / 2 - unknowns) as f64;
        let judged = |noise| {
            let options = Options { noise, ..Options::of(transform) };
            fit_frame(&pairs, &options).unwrap().reflection.unwrap()
        };
        let estimated = judged(Noise::Estimated);
        let (proper, improper) = (estimated.proper_rms_mm, estimated.improper_rms_mm);
        let expected = dof * (proper / improper).ln();
        assert!(expected.abs() > 0.01, "both fit alike: {expected}");
        let off = estimated.log_likelihood_ratio / expected - 1.0;
        assert!(off.abs() < RATIO_TOL, "{transform} {D}-d: {off:.1e}");

        let declared = judged(Noise::Declared);
        let chi2 = [declared.proper_rms_mm, declared.improper_rms_mm]
            .map(|rms_mm| n * (rms_mm / sigma_mm).powi(2));
        let excess = (chi2[0].min(chi2[1]) / dof).max(1.0);
        let off = declared.log_likelihood_ratio / (0.5 * (chi2[0] - chi2[1]) / excess) - 1.0;
        assert!(off.abs() < RATIO_TOL, "{transform} {D}-d: {off:.1e}");
    }
}

#[test]
fn the_ratio_is_that_of_two_normal_likelihoods() {
    ratio_follows_from_the_distances::<2>(23);
    ratio_follows_from_the_distances::<3>(24);
}
