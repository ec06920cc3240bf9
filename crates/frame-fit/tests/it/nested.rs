//! F-tests between the families.

use frame_fit::{NestedTest, Noise, Options, Transform, Uncertainty, compare_transforms};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::scene;

const SIGMA: Uncertainty<3> = Uncertainty::Isotropic { sigma_mm: 0.02 };

fn test_of(tests: &[NestedTest], smaller: Transform) -> NestedTest {
    *tests.iter().find(|t| t.smaller == smaller).unwrap()
}

/// Rejections at 5 % of a true smaller family; four standard deviations of 2000 trials.
#[test]
fn a_true_family_is_rejected_as_often_as_stated() {
    const TRIALS: u32 = 2000;
    const BOUND: f64 = 4.0 * 0.004_87;
    for truth in [Transform::None, Transform::Translation, Transform::Rigid, Transform::Similarity]
    {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let (mut by_f, mut by_chi2) = (0, 0);
        for _ in 0..TRIALS {
            let map = scene::random_map::<3>(&mut rng, truth);
            let points = scene::cloud(&mut rng, 8, 300.0);
            let mut pairs = scene::exact(&points, &map, SIGMA);
            scene::disturb(&mut rng, &mut pairs);
            let test = test_of(&compare_transforms(&pairs, &Options::default()).unwrap(), truth);
            by_f += u32::from(test.p_value < 0.05);
            by_chi2 += u32::from(test.declared_p_value.unwrap() < 0.05);
        }
        for rejected in [by_f, by_chi2] {
            let share = f64::from(rejected) / f64::from(TRIALS);
            assert!((share - 0.05).abs() < BOUND, "{truth}: {share}");
        }
    }
}

/// A frame that was not built parallel to the machine: translation alone, T = [I, M − L], which
/// document [B] uses, is rejected by the rotation it leaves out.
#[test]
fn translation_alone_is_rejected_for_a_frame_that_is_not_parallel() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let mut map = scene::random_map::<3>(&mut rng, Transform::Translation);
    let tilt = nalgebra::Rotation3::from_scaled_axis(nalgebra::Vector3::new(2e-4, 0.0, -3e-4));
    map.linear = *tilt.matrix();
    let points = scene::cloud(&mut rng, 8, 500.0);
    let mut pairs = scene::exact(&points, &map, SIGMA);
    scene::disturb(&mut rng, &mut pairs);
    let tests = compare_transforms(&pairs, &Options::default()).unwrap();
    assert!(test_of(&tests, Transform::Translation).p_value < 1e-6);
    assert!(test_of(&tests, Transform::Rigid).p_value > 0.01);
    assert!(test_of(&tests, Transform::Similarity).p_value > 0.01);
}

#[test]
fn the_degrees_of_freedom_add_up() {
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    let map = scene::random_map::<3>(&mut rng, Transform::Rigid);
    let points = scene::cloud(&mut rng, 6, 300.0);
    let mut pairs = scene::exact(&points, &map, SIGMA);
    scene::disturb(&mut rng, &mut pairs);
    let options = Options { noise: Noise::Estimated, ..Options::default() };
    let tests = compare_transforms(&pairs, &options).unwrap();
    let table: Vec<_> = tests.iter().map(|t| (t.numerator_dof, t.denominator_dof)).collect();
    assert_eq!(table, [(3, 15), (3, 12), (1, 11), (5, 6)]);
    assert!(tests.iter().all(|t| t.declared_p_value.is_none()));
}

/// Four coplanar points determine no affine map, and three leave a similarity little to say.
#[test]
fn families_that_the_points_do_not_determine_are_left_out() {
    let mut rng = ChaCha8Rng::seed_from_u64(14);
    let map = scene::random_map::<3>(&mut rng, Transform::Rigid);
    let mut points = scene::cloud::<3>(&mut rng, 4, 300.0);
    for point in &mut points {
        point.z = 0.0;
    }
    let mut pairs = scene::exact(&points, &map, SIGMA);
    scene::disturb(&mut rng, &mut pairs);
    let tests = compare_transforms(&pairs, &Options::default()).unwrap();
    assert_eq!(tests.last().unwrap().larger, Transform::Similarity);
}

#[test]
fn exact_points_prefer_the_smaller_family() {
    let mut rng = ChaCha8Rng::seed_from_u64(15);
    let map = scene::random_map::<3>(&mut rng, Transform::Rigid);
    let points = scene::cloud(&mut rng, 8, 300.0);
    let pairs = scene::exact(&points, &map, SIGMA);
    let tests = compare_transforms(&pairs, &Options::default()).unwrap();
    assert!(test_of(&tests, Transform::Translation).p_value < 1e-9);
    assert!(test_of(&tests, Transform::Rigid).p_value > 0.05);
    assert!(test_of(&tests, Transform::Similarity).p_value > 0.05);
}
