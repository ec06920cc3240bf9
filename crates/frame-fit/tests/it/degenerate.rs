//! What the data cannot determine is an error that says so.

use frame_fit::{
    FrameFitError, FrameMap, FreeMotion, InvalidPair, Noise, Options, PointPair, Transform,
    Uncertainty, fit_frame,
};
use nalgebra::{Point2, Point3, SMatrix, SVector, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::scene;

fn on_a_line(n: u8, direction: Vector3<f64>) -> Vec<PointPair<3>> {
    (0..n)
        .map(|k| {
            let source = Point3::new(10.0, 20.0, 30.0) + direction * f64::from(k) * 50.0;
            let target = Point3::new(source.y + 5.0, -source.x, source.z);
            PointPair::isotropic(source, target, 0.01)
        })
        .collect()
}

#[test]
fn collinear_points_leave_the_rotation_about_their_line() {
    let direction = Vector3::new(2.0, -1.0, 2.0) / 3.0;
    for transform in [Transform::Rigid, Transform::Similarity] {
        let error = fit_frame(&on_a_line(5, direction), &Options::of(transform)).unwrap_err();
        let FrameFitError::Degenerate {
            spreads_mm, free: FreeMotion::RotationAbout { axis }, ..
        } = &error
        else {
            panic!("{error}");
        };
        let cosine: f64 = axis.iter().zip(direction.iter()).map(|(a, b)| a * b).sum();
        assert!((cosine.abs() - 1.0).abs() < 1e-12, "{axis:?}");
        // Five points 50 mm apart: 50 √2 mm rms, and nothing across.
        assert!((spreads_mm[0] - 50.0 * 2.0_f64.sqrt()).abs() < 1e-9);
        assert!(spreads_mm[1] < 1e-9 && spreads_mm[2] < 1e-9);
        assert!(error.to_string().contains("rotation about the line"), "{error}");
    }
    let translation = fit_frame(&on_a_line(5, direction), &Options::of(Transform::Translation));
    assert!(translation.is_ok());
}

#[test]
fn coincident_points_leave_every_rotation() {
    let pairs = [PointPair::isotropic([1.0, 2.0, 3.0], [4.0, 5.0, 6.0], 0.01); 4];
    let error = fit_frame(&pairs, &Options::default()).unwrap_err();
    let free = FreeMotion::EveryRotation;
    assert!(matches!(&error, FrameFitError::Degenerate { free: f, .. } if *f == free), "{error}");
    let pairs = [PointPair::isotropic([1.0, 2.0], [4.0, 5.0], 0.01); 4];
    let error = fit_frame(&pairs, &Options::default()).unwrap_err();
    assert!(matches!(error, FrameFitError::Degenerate { .. }), "{error}");
    let translation = fit_frame(&pairs, &Options::of(Transform::Translation)).unwrap();
    assert!(
        (translation.target_from_source.translation_mm - SVector::from([3.0, 3.0])).norm() < 1e-12
    );
}

#[test]
fn coplanar_points_leave_the_map_along_their_normal() {
    let pairs: Vec<_> = [[0.0, 0.0], [100.0, 0.0], [0.0, 80.0], [90.0, 70.0], [10.0, 33.0]]
        .map(|[x, y]| PointPair::isotropic([x, y, 5.0], [x, y, 5.0], 0.01))
        .to_vec();
    let error = fit_frame(&pairs, &Options::of(Transform::Affine)).unwrap_err();
    let FrameFitError::Degenerate { free: FreeMotion::MapAlong { direction }, .. } = &error else {
        panic!("{error}");
    };
    assert!((direction[2].abs() - 1.0).abs() < 1e-12, "{direction:?}");
    assert!(fit_frame(&pairs, &Options::default()).is_ok());
}

/// Points that are as good as collinear at the noise they have.
#[test]
fn noise_as_large_as_the_spread_is_an_error() {
    let mut pairs = on_a_line(5, Vector3::x());
    let sides = [0.3, -0.2, 0.1, -0.4, 0.2];
    for (pair, side) in pairs.iter_mut().zip(sides) {
        // Half a millimetre of unevenness, a millimetre of noise.
        pair.source_mm.y += side;
        pair.target_mm = pair.source_mm;
        pair.uncertainty = Uncertainty::Isotropic { sigma_mm: 1.0 };
    }
    let error = fit_frame(&pairs, &Options::default()).unwrap_err();
    assert!(
        matches!(error, FrameFitError::TooNoisy { parameter: "rx", sigma, .. } if sigma > 1.0),
        "{error}"
    );
    // The same sigma as a mere weight: the residuals say that the noise is nil.
    let options = Options { noise: Noise::Estimated, ..Options::default() };
    assert!(fit_frame(&pairs, &options).is_ok());
}

#[test]
fn too_few_points_name_the_number_that_is_needed() {
    let pair = PointPair::isotropic([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], 0.01);
    for (transform, needed) in [
        (Transform::None, 1),
        (Transform::Translation, 1),
        (Transform::Rigid, 3),
        (Transform::Similarity, 3),
        (Transform::Affine, 4),
    ] {
        let pairs = vec![pair; needed - 1];
        let error = fit_frame(&pairs, &Options::of(transform)).unwrap_err();
        assert_eq!(error, FrameFitError::TooFewPoints { transform, needed, got: needed - 1 });
    }
}

#[test]
fn two_points_fix_a_planar_frame() {
    let pairs = [
        PointPair::isotropic([0.0, 0.0], [10.0, 10.0], 0.01),
        PointPair::isotropic([100.0, 0.0], [10.0, 110.02], 0.01),
    ];
    let fit = fit_frame(&pairs, &Options::default()).unwrap();
    // A quarter turn, and the 20 µm between the lengths shared by both ends.
    assert_eq!(fit.degrees_of_freedom, 1);
    assert!((fit.residuals_mm[0].norm() - 0.01).abs() < 1e-9);
    let sigma = fit.standard_uncertainties().unwrap()[2];
    // Two ends of 10 µm at ± 50 mm: 0.01 / (50 √2) rad.
    assert!((sigma - 0.01 / (50.0 * 2.0_f64.sqrt())).abs() < 1e-8, "{sigma}");
    let similarity = fit_frame(&pairs, &Options::of(Transform::Similarity)).unwrap();
    assert_eq!(similarity.degrees_of_freedom, 0);
    assert!(similarity.variance_factor.is_none());
}

/// Uncertainties without redundancy: stated when declared, not invented when estimated.
#[test]
fn without_redundancy_the_noise_cannot_be_estimated() {
    let pairs = [
        PointPair::isotropic([0.0, 0.0], [10.0, 10.0], 0.01),
        PointPair::isotropic([100.0, 0.0], [10.0, 110.02], 0.01),
    ];
    let options = Options { noise: Noise::Estimated, ..Options::of(Transform::Similarity) };
    let fit = fit_frame(&pairs, &options).unwrap();
    assert!(fit.standard_uncertainties().is_none());
    assert!(fit.half_widths(0.95).is_none());
    assert!(fit.point_covariance_mm2(&Point2::origin()).is_none());
}

/// A square whose corners are paired with two points in turn: no rotation is better than any
/// other.
#[test]
fn wrong_pairing_that_leaves_the_rotation_open_is_an_error() {
    let pairs = [
        PointPair::isotropic([50.0, 50.0], [0.0, 50.0], 0.01),
        PointPair::isotropic([-50.0, 50.0], [0.0, -50.0], 0.01),
        PointPair::isotropic([-50.0, -50.0], [0.0, 50.0], 0.01),
        PointPair::isotropic([50.0, -50.0], [0.0, -50.0], 0.01),
    ];
    let result = fit_frame(&pairs, &Options::default());
    assert!(matches!(result, Err(FrameFitError::Ambiguous { .. })), "{result:?}");
}

/// Far from the origin only the places of the coordinates are lost: 1e5 mm · 2⁻⁵² · 20.
#[test]
fn a_frame_far_from_its_origin_is_as_good() {
    const FAR_TOL_MM: f64 = 4e-10;
    let mut rng = ChaCha8Rng::seed_from_u64(31);
    for transform in [Transform::Rigid, Transform::Similarity, Transform::Affine] {
        let truth = scene::random_map::<3>(&mut rng, transform);
        let mut points = scene::cloud::<3>(&mut rng, 8, 200.0);
        for point in &mut points {
            *point += SVector::from([1e5, -1e5, 1e5]);
        }
        let sigma = Uncertainty::Isotropic { sigma_mm: 0.01 };
        let mut pairs = scene::exact(&points, &truth, sigma);
        let exact = fit_frame(&pairs, &Options::of(transform)).unwrap();
        for residual in &exact.residuals_mm {
            assert!(residual.norm() < FAR_TOL_MM, "{transform}: {} mm", residual.norm());
        }
        scene::disturb(&mut rng, &mut pairs);
        let far = fit_frame(&pairs, &Options::of(transform)).unwrap();
        for pair in &mut pairs {
            pair.source_mm -= SVector::from([1e5, -1e5, 1e5]);
        }
        let near = fit_frame(&pairs, &Options::of(transform)).unwrap();
        for (a, b) in far.residuals_mm.iter().zip(&near.residuals_mm) {
            assert!((a - b).norm() < FAR_TOL_MM);
        }
        for (a, b) in far.covariance.iter().zip(near.covariance.iter()) {
            // Relative to the largest entry, 12 digits of 1e5/200 are spent.
            assert!((a - b).abs() < 1e-9 * near.covariance.amax());
        }
    }
}

/// Points of 1 nm among points of 1 mm: the good ones decide, and the error of each is its own.
#[test]
fn uncertainties_over_six_decades() {
    let mut rng = ChaCha8Rng::seed_from_u64(32);
    for _ in 0..50 {
        let truth = scene::random_map::<3>(&mut rng, Transform::Rigid);
        let points = scene::cloud(&mut rng, 9, 200.0);
        let mut pairs = scene::exact(&points, &truth, Uncertainty::Isotropic { sigma_mm: 1.0 });
        for (k, pair) in pairs.iter_mut().enumerate() {
            let sigma_mm = 10_f64.powi(if k < 3 { -6 } else { -(rng.random_range(0..4)) });
            pair.uncertainty = Uncertainty::Isotropic { sigma_mm };
        }
        scene::disturb(&mut rng, &mut pairs);
        let Ok(fit) = fit_frame(&pairs, &Options::default()) else { panic!("no fit") };
        let best = fit_frame(&pairs[..3], &Options::default()).unwrap();
        let moved = |map: &FrameMap<3>| map.apply(&points[0]);
        let difference = moved(&fit.target_from_source) - moved(&best.target_from_source);
        // What the coarse points can move the fine ones by is far below a nanometre.
        assert!(difference.norm() < 5e-6, "{}", difference.norm());
        let chi2 = fit.variance_factor.unwrap() * 21.0;
        // χ² with 21 degrees of freedom is below 75 but for 5e-8.
        assert!(chi2 < 75.0, "{chi2}");
    }
}

#[test]
fn bad_input_names_the_pair() {
    let good = PointPair::isotropic([0.0, 0.0, 1.0], [0.0, 1.0, 0.0], 0.01);
    let bad_at_2 = |pair: PointPair<3>| {
        let error = fit_frame(&[good, good, pair, good], &Options::default()).unwrap_err();
        let FrameFitError::InvalidPair { index: 2, reason } = error else { panic!("{error}") };
        reason
    };
    let coordinate = |value: f64| {
        let mut pair = good;
        pair.target_mm.y = value;
        bad_at_2(pair)
    };
    for value in [f64::NAN, f64::INFINITY, 1e300, -1e13] {
        assert!(matches!(coordinate(value), InvalidPair::Coordinate { .. }));
    }
    let uncertain = |uncertainty| bad_at_2(PointPair { uncertainty, ..good });
    for sigma_mm in [0.0, -0.01, f64::NAN, f64::INFINITY, 1e300, 1e-300] {
        let reason = uncertain(Uncertainty::Isotropic { sigma_mm });
        assert!(matches!(reason, InvalidPair::Sigma { .. }), "{reason}");
        let reason =
            uncertain(Uncertainty::PerAxis { sigma_mm: SVector::from([0.01, sigma_mm, 0.01]) });
        assert!(matches!(reason, InvalidPair::Sigma { .. }), "{reason}");
    }
    let full =
        |m: [[f64; 3]; 3]| uncertain(Uncertainty::Full { covariance_mm2: SMatrix::from(m) * 1e-4 });
    let lopsided = full([[1.0, 0.5, 0.0], [0.1, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    assert!(matches!(lopsided, InvalidPair::Asymmetric { .. }), "{lopsided}");
    let indefinite = full([[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    assert!(matches!(indefinite, InvalidPair::NotPositiveDefinite), "{indefinite}");
    let negative = full([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    assert!(matches!(negative, InvalidPair::Sigma { .. }), "{negative}");
    let nan = full([[1.0, f64::NAN, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    assert!(matches!(nan, InvalidPair::NotPositiveDefinite), "{nan}");
}

/// Directions are given to a thousandth, and what is smaller is not rounded to nought.
#[test]
fn free_motions_say_which() {
    let axis = vec![0.0, -1.0, 5e-4];
    let text = FreeMotion::RotationAbout { axis: axis.clone() }.to_string();
    assert_eq!(text, "the rotation about the line (0.000, -1.000, 5.0e-4) of the points");
    let text = FreeMotion::MapAlong { direction: axis }.to_string();
    assert_eq!(text, "stretch and shear along (0.000, -1.000, 5.0e-4)");
    assert_eq!(FreeMotion::EveryRotation.to_string(), "every rotation about the common point");
}
