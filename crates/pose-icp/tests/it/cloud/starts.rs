//! From how far off a pose is found, and with nothing known of it.

use nalgebra::{Isometry3, Point3, Unit, UnitQuaternion, Vector3};
use pose_icp::{
    CloudTarget, PointCloud, RegisterError, RegisterOptions, find_start, register_to_cloud,
};
use rand::RngExt;

use super::scene::{self, miss_mm};

const SIGMA_MM: f64 = 2e-3;

/// Poses known this well are those of the right place: uncertainty is a thousandth of it, the next
/// place where the waves fit is millimetres off.
const FOUND_MM: f64 = 0.05;

fn direction(rng: &mut impl rand::Rng) -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::from([(); 3].map(|()| rng.random_range(-1.0..1.0))))
}

/// `truth` after a turn about the middle of the source and a shift, both in random directions.
fn off(
    rng: &mut impl rand::Rng,
    truth: &Isometry3<f64>,
    turn_rad: f64,
    shift_mm: f64,
) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_axis_angle(&direction(rng), turn_rad);
    let shift = direction(rng).into_inner() * shift_mm;
    Isometry3::from_parts(shift.into(), turn) * truth
}

#[test]
fn a_shift_by_a_third_of_the_part_is_found_back() {
    let mut rng = scene::rng(70);
    let target = CloudTarget::new(&scene::target(&mut rng, 120)).unwrap();
    let truth = scene::small_pose();
    let source = scene::source(&mut rng, 3000, SIGMA_MM, &truth);
    for _ in 0..10 {
        let start = off(&mut rng, &truth, 0.3, 33.0);
        let options = RegisterOptions { start, ..Default::default() };
        let found = register_to_cloud(&source, &target, &options).unwrap();
        let miss = miss_mm(&source, &found.target_from_source, &truth);
        assert!(miss < FOUND_MM, "misses by {miss} mm");
    }
}

#[test]
fn a_shift_with_half_an_overlap_is_found_back() {
    let mut rng = scene::rng(71);
    let (target, truth) = (half(&mut rng), scene::small_pose());
    let source = scene::source(&mut rng, 3000, SIGMA_MM, &truth);
    for _ in 0..5 {
        let start = off(&mut rng, &truth, 0.1, 5.0);
        let options = RegisterOptions { start, ..Default::default() };
        let found = register_to_cloud(&source, &target, &options).unwrap();
        let miss = miss_mm(&source, &found.target_from_source, &truth);
        assert!(miss < FOUND_MM, "misses by {miss} mm");
    }
}

/// The side of x < 5 mm.
fn half(rng: &mut impl rand::Rng) -> CloudTarget {
    let whole = scene::target(rng, 120);
    let normals = whole.normals.unwrap();
    let both = whole.points_mm.into_iter().zip(normals).filter(|(p, _)| p.x < 5.0);
    let (points_mm, normals) = both.unzip();
    CloudTarget::new(&PointCloud::with_normals(points_mm, normals)).unwrap()
}

#[test]
fn nothing_need_be_known_of_the_start() {
    let mut rng = scene::rng(72);
    let target = CloudTarget::new(&scene::target(&mut rng, 120)).unwrap();
    for _ in 0..8 {
        let turn =
            UnitQuaternion::from_axis_angle(&direction(&mut rng), rng.random_range(0.0..3.1));
        let place = Vector3::from([(); 3].map(|()| rng.random_range(-900.0..900.0)));
        let truth = Isometry3::from_parts(place.into(), turn);
        let source = scene::source(&mut rng, 3000, SIGMA_MM, &truth);
        let options = RegisterOptions::default();
        let start = find_start(&source, &target, &options).unwrap();
        let options = RegisterOptions { start, ..options };
        let found = register_to_cloud(&source, &target, &options).unwrap();
        let miss = miss_mm(&source, &found.target_from_source, &truth);
        assert!(miss < FOUND_MM, "misses by {miss} mm");
    }
}

#[test]
fn a_start_has_the_same_bits_on_any_number_of_threads() {
    let mut rng = scene::rng(73);
    let target = half(&mut rng);
    let truth = Isometry3::new(Vector3::new(40.0, -9.0, 300.0), Vector3::new(0.9, -1.8, 0.4));
    let source = scene::source(&mut rng, 70_000, SIGMA_MM, &truth);
    let [one, two, three, eight] = [1, 2, 3, 8].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| find_start(&source, &target, &RegisterOptions::default()).unwrap())
    });
    assert_eq!(one, two);
    assert_eq!(one, three);
    assert_eq!(one, eight);
}

#[test]
fn what_has_no_start_is_an_error_and_no_panic() {
    let mut rng = scene::rng(74);
    let cloud = scene::target(&mut rng, 30);
    let target = CloudTarget::new(&cloud).unwrap();
    let options = RegisterOptions::default();
    let of = |points: Vec<Point3<f64>>| find_start(&PointCloud::new(points), &target, &options);
    assert!(matches!(of(vec![]), Err(RegisterError::Empty { .. })));
    let bad = vec![Point3::new(0.0, f64::NAN, 0.0); 10];
    assert!(matches!(of(bad), Err(RegisterError::InvalidPoint { index: 0, .. })));
    let few = of(vec![Point3::origin(); 3]);
    assert!(matches!(few, Err(RegisterError::TooFewPoints { got: 3, .. })), "{few:?}");
    // One point many times lies anywhere: any answer will do, as long as it is one of numbers.
    if let Ok(start) = of(vec![Point3::new(5.0, 5.0, 5.0); 100]) {
        assert!(start.translation.vector.iter().all(|v| v.is_finite()));
    }
    let bare = CloudTarget::new(&PointCloud::new(cloud.points_mm)).unwrap();
    let source = scene::source(&mut rng, 100, SIGMA_MM, &Isometry3::identity());
    let error = find_start(&source, &bare, &options).unwrap_err();
    assert!(matches!(error, RegisterError::MissingNormals { .. }), "{error}");
}
