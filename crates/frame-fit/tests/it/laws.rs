//! What holds for every pose, shape and family.

use frame_fit::{
    FrameFitError, FrameMap, Handedness, Options, PointPair, Transform, Uncertainty, fit_frame,
    shape_of,
};
use nalgebra::{Point, SMatrix, SVector};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::scene;

/// Round-off of one fit over 1 m: 1e3 mm · 2⁻⁵² · 50 operations, for coordinates of 2 m.
const EXACT_TOL_MM: f64 = 4e-11;
/// Two minimisers of the same sum of squares: the solver's step tolerance over 1 m, and the
/// square root of round-off where the cost is flat, both below a picometre.
const SAME_MINIMUM_TOL_MM: f64 = 1e-9;

const FITTED: [Transform; 4] =
    [Transform::Translation, Transform::Rigid, Transform::Similarity, Transform::Affine];

fn recovers<const D: usize>(seed: u64) -> Result<(), TestCaseError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for transform in FITTED {
        let truth = scene::random_map::<D>(&mut rng, transform);
        let n = transform.minimum_points(D) + rng.random_range(0..5);
        let points = scene::cloud(&mut rng, n.max(2), 500.0);
        let uncertainty = scene::random_uncertainty(&mut rng, 0.01);
        let mut pairs = scene::exact(&points, &truth, uncertainty);
        for pair in &mut pairs {
            pair.uncertainty = scene::random_uncertainty(&mut rng, 0.01);
        }
        // Random points may lie close to a line; the error then grows with their condition.
        let fit = match fit_frame(&pairs, &Options::of(transform)) {
            Err(FrameFitError::TooNoisy { .. }) => continue,
            fit => fit.unwrap(),
        };
        for residual in &fit.residuals_mm {
            prop_assert!(residual.norm() < EXACT_TOL_MM, "{transform} {} mm", residual.norm());
        }
        prop_assert_eq!(fit.degrees_of_freedom, D * n.max(2) - transform.parameter_count(D));
        if fit.report.condition < 1e2 {
            let distance = scene::map_distance_mm(&fit.target_from_source, &truth, 500.0);
            prop_assert!(distance < 50.0 * EXACT_TOL_MM, "{transform} {distance} mm");
        }
    }
    Ok(())
}

/// Gradient of the weighted sum of squares along every parameter, by its definition.
fn stationary<const D: usize>(seed: u64) -> Result<(), TestCaseError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for transform in FITTED {
        let truth = scene::random_map::<D>(&mut rng, transform);
        let points = scene::cloud(&mut rng, 8, 500.0);
        let mut pairs = scene::exact(&points, &truth, Uncertainty::Isotropic { sigma_mm: 1.0 });
        for pair in &mut pairs {
            pair.uncertainty = scene::random_uncertainty(&mut rng, 0.05);
        }
        scene::disturb(&mut rng, &mut pairs);
        let fit = fit_frame(&pairs, &Options::of(transform)).unwrap();
        let cost =
            |map: &FrameMap<D>| -> f64 { pairs.iter().map(|p| whitened_square(p, map)).sum() };
        let best = cost(&fit.target_from_source);
        // Any other member of the family near by costs more.
        for _ in 0..20 {
            let nudge = nudge::<D>(&mut rng, transform, 1e-4);
            let moved = nudge.after(&fit.target_from_source);
            prop_assert!(cost(&moved) > best, "{transform}: {} < {best}", cost(&moved));
        }
    }
    Ok(())
}

fn whitened_square<const D: usize>(pair: &PointPair<D>, map: &FrameMap<D>) -> f64 {
    let r = pair.target_mm - map.apply(&pair.source_mm);
    let covariance = pair.uncertainty.covariance_mm2();
    let covariance = nalgebra::DMatrix::from_column_slice(D, D, covariance.as_slice());
    let r = nalgebra::DVector::from_column_slice(r.as_slice());
    r.dot(&covariance.cholesky().unwrap().solve(&r))
}

fn nudge<const D: usize>(rng: &mut ChaCha8Rng, transform: Transform, size: f64) -> FrameMap<D> {
    let mut map = FrameMap::<D>::identity();
    map.translation_mm = scene::uniform(rng, size * 100.0);
    if transform.has_rotation() {
        let spin = scene::uniform::<3>(rng, size);
        let spin = if D == 2 { nalgebra::Vector3::new(0.0, 0.0, spin.z) } else { spin };
        let rotation = nalgebra::Rotation3::from_scaled_axis(spin);
        map.linear = SMatrix::from_fn(|i, j| rotation[(i, j)]);
    }
    match transform {
        Transform::Similarity => map.linear *= 1.0 + rng.random_range(-size..size),
        Transform::Affine => {
            map.linear += SMatrix::from_fn(|_, _| rng.random_range(-size..size));
        }
        _ => {}
    }
    map
}

proptest! {
    #![proptest_config(crate::seeded(60))]

    #[test]
    fn exact_points_are_recovered(seed in any::<u64>()) {
        recovers::<2>(seed)?;
        recovers::<3>(seed)?;
    }

    #[test]
    fn no_neighbour_fits_better(seed in any::<u64>()) {
        stationary::<2>(seed)?;
        stationary::<3>(seed)?;
    }

    #[test]
    fn swapping_the_frames_inverts_the_rigid_transform(seed in any::<u64>()) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let truth = scene::random_map::<3>(&mut rng, Transform::Rigid);
        let points = scene::cloud(&mut rng, 8, 500.0);
        let sigma = Uncertainty::Isotropic { sigma_mm: 0.01 };
        let mut pairs = scene::exact(&points, &truth, sigma);
        scene::disturb(&mut rng, &mut pairs);
        let swap = |p: &PointPair<3>| PointPair { target_mm: p.source_mm, source_mm: p.target_mm, ..*p };
        let swapped: Vec<_> = pairs.iter().map(swap).collect();
        let there = fit_frame(&pairs, &Options::default()).unwrap().target_from_source;
        let back = fit_frame(&swapped, &Options::default()).unwrap().target_from_source;
        let distance = scene::map_distance_mm(&there.after(&back), &FrameMap::identity(), 500.0);
        prop_assert!(distance < SAME_MINIMUM_TOL_MM, "{distance} mm");
    }

    /// A weight of k is k points; equal covariances stated in three ways are equal.
    #[test]
    fn weights_count_points(seed in any::<u64>()) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let truth = scene::random_map::<3>(&mut rng, Transform::Similarity);
        let points = scene::cloud(&mut rng, 6, 500.0);
        let mut pairs = scene::exact(&points, &truth, Uncertainty::Isotropic { sigma_mm: 0.02 });
        scene::disturb(&mut rng, &mut pairs);
        let mut repeated = pairs.clone();
        repeated.extend([pairs[2]; 3]);
        // Four readings of one point weigh as one reading of half the sigma.
        pairs[2].uncertainty = Uncertainty::Full {
            covariance_mm2: SMatrix::identity() * 0.01_f64.powi(2),
        };
        pairs[3].uncertainty = Uncertainty::PerAxis { sigma_mm: SVector::repeat(0.02) };
        let options = Options::of(Transform::Similarity);
        let (weighted, counted) =
            (fit_frame(&pairs, &options).unwrap(), fit_frame(&repeated, &options).unwrap());
        let distance = scene::map_distance_mm(
            &weighted.target_from_source,
            &counted.target_from_source,
            500.0,
        );
        prop_assert!(distance < SAME_MINIMUM_TOL_MM, "{distance} mm");
        for (a, b) in weighted.covariance.iter().zip(counted.covariance.iter()) {
            let scale = weighted.covariance.amax();
            prop_assert!((a - b).abs() < 1e-9 * scale, "{a} {b}");
        }
    }

    /// Lengths in another unit: the result follows.
    #[test]
    fn the_unit_of_length_does_not_matter(seed in any::<u64>(), power in -5_i32..6) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let unit = 10_f64.powi(power);
        let truth = scene::random_map::<3>(&mut rng, Transform::Rigid);
        let points = scene::cloud(&mut rng, 7, 500.0);
        let mut pairs = scene::exact(&points, &truth, Uncertainty::Isotropic { sigma_mm: 0.02 });
        scene::disturb(&mut rng, &mut pairs);
        let scaled: Vec<_> = pairs.iter().map(|p| PointPair {
            target_mm: p.target_mm * unit,
            source_mm: p.source_mm * unit,
            uncertainty: Uncertainty::Isotropic { sigma_mm: 0.02 * unit },
        }).collect();
        let fit = fit_frame(&pairs, &Options::default()).unwrap();
        let other = fit_frame(&scaled, &Options::default()).unwrap();
        prop_assert!((fit.rms_mm() * unit / other.rms_mm() - 1.0).abs() < 1e-9);
        let (a, b) = (fit.standard_uncertainties().unwrap(), other.standard_uncertainties().unwrap());
        for k in 0..6 {
            let expected = if k < 3 { a[k] * unit } else { a[k] };
            prop_assert!((b[k] / expected - 1.0).abs() < 1e-9, "parameter {k}");
        }
    }

    /// The pivot is bookkeeping: the covariance of an image does not depend on it.
    #[test]
    fn the_covariance_moves_with_its_pivot(seed in any::<u64>()) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let truth = scene::random_map::<3>(&mut rng, Transform::Rigid);
        let points = scene::cloud(&mut rng, 6, 300.0);
        let pairs = scene::exact(&points, &truth, Uncertainty::Isotropic { sigma_mm: 0.02 });
        let fit = fit_frame(&pairs, &Options::default()).unwrap();
        let place: Point<f64, 3> = Point::from(scene::uniform(&mut rng, 1000.0));
        let image = fit.target_from_source.apply(&place);
        // About the image itself, its covariance is that of the translation.
        let about_image = fit.covariance_about(&image);
        let direct = fit.point_covariance_mm2(&place).unwrap();
        for i in 0..3 {
            for j in 0..3 {
                let difference = (about_image[(i, j)] - direct[(i, j)]).abs();
                prop_assert!(difference < 1e-11 * direct.amax(), "{difference}");
            }
        }
    }

    #[test]
    fn a_map_has_the_shape_it_was_made_of(seed in any::<u64>()) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let rotation = scene::random_map::<3>(&mut rng, Transform::Rigid).linear;
        let scales = SVector::<f64, 3>::from_fn(|_, _| rng.random_range(0.8..1.2));
        let shear = rng.random_range(-0.1..0.1_f64);
        // y leans towards x by `shear`, then each axis keeps its own length.
        let mut leaning = SMatrix::<f64, 3, 3>::identity();
        leaning[(0, 1)] = shear.sin();
        leaning[(1, 1)] = shear.cos();
        let linear = rotation * leaning * SMatrix::from_diagonal(&scales);
        let shape = shape_of(&FrameMap { linear, translation_mm: SVector::zeros() });
        prop_assert!((shape.axis_scales - scales).amax() < 1e-13);
        prop_assert!((shape.shears_rad[0] - shear).abs() < 1e-13);
        prop_assert!(shape.shears_rad[1].abs() < 1e-13 && shape.shears_rad[2].abs() < 1e-13);
        prop_assert_eq!(shape.handedness, Handedness::Proper);
        let volume = scales.product() * shear.cos();
        prop_assert!((shape.mean_scale.powi(3) / volume - 1.0).abs() < 1e-13);
        // Singular values are the largest and smallest stretch of any direction.
        for _ in 0..20 {
            let direction = scene::gauss::<3>(&mut rng).normalize();
            let stretch = (linear * direction).norm();
            prop_assert!(stretch <= shape.principal_scales[0] + 1e-13);
            prop_assert!(stretch >= shape.principal_scales[2] - 1e-13);
        }
    }
}

#[test]
fn an_inverse_undoes_the_map() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for transform in FITTED {
        let map = scene::random_map::<2>(&mut rng, transform);
        let back = map.inverse().unwrap().after(&map);
        assert!(scene::map_distance_mm(&back, &FrameMap::identity(), 500.0) < 1e-11);
    }
    let flat = FrameMap::<2> { linear: SMatrix::zeros(), translation_mm: SVector::zeros() };
    assert!(flat.inverse().is_none());
}

#[test]
fn a_rigid_map_is_a_pose_and_an_affine_one_is_not() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let rigid = scene::random_map::<3>(&mut rng, Transform::Rigid);
    let pose = rigid.isometry().unwrap();
    assert!(scene::map_distance_mm(&FrameMap::from(pose), &rigid, 500.0) < 1e-11);
    let affine = scene::random_map::<3>(&mut rng, Transform::Affine);
    assert!(affine.isometry().is_none());
    let mut mirrored = rigid;
    mirrored.linear.column_mut(0).neg_mut();
    assert!(mirrored.isometry().is_none());
}

/// Where all points weigh alike in every direction, the closed form is the minimum already: nothing
/// is left for the iteration but to find that out.
#[test]
fn a_closed_form_needs_no_iteration() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for transform in FITTED {
        let truth = scene::random_map::<3>(&mut rng, transform);
        let points = scene::cloud(&mut rng, 9, 500.0);
        let mut pairs = scene::exact(&points, &truth, Uncertainty::Isotropic { sigma_mm: 0.02 });
        for (k, pair) in pairs.iter_mut().enumerate() {
            pair.uncertainty = Uncertainty::Isotropic { sigma_mm: 0.01 * (1.0 + k as f64) };
        }
        scene::disturb(&mut rng, &mut pairs);
        let fit = fit_frame(&pairs, &Options::of(transform)).unwrap();
        assert!(fit.report.iterations <= 1, "{transform}: {}", fit.report);
    }
}
