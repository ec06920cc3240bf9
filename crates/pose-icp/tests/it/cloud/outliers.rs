//! Robust losses, trimming, partial overlap.

use least_squares::Loss;
use nalgebra::{Isometry3, Point3, Vector3};
use pose_icp::{CloudTarget, PointCloud, RegisterOptions, register_to_cloud};
use rand::RngExt;

use super::scene::{self, miss_mm, small_pose};

const SIGMA_MM: f64 = 2e-3;

/// Nine tenths of the surface, one tenth up to 3 mm above it: dirt lies on one side only.
fn dirty(seed: u64) -> PointCloud {
    let mut rng = scene::rng(seed);
    let mut cloud = scene::source(&mut rng, 5000, SIGMA_MM, &small_pose());
    for point in cloud.points_mm.iter_mut().step_by(10) {
        point.z += rng.random_range(0.2..3.0);
    }
    cloud
}

/// Pose uncertainty of 5000 points of 2 µm is near 0.1 µm in z and ten times that sideways, on a
/// surface whose slopes are a tenth; four sigma.
const CLEAN_MM: f64 = 4e-3;

#[test]
fn each_loss_and_trimming_bear_a_tenth_of_dirt() {
    let mut rng = scene::rng(40);
    let target = CloudTarget::new(&scene::target(&mut rng, 150)).unwrap();
    let source = dirty(41);
    let truth = small_pose();
    let miss = |options: &RegisterOptions| {
        let found = register_to_cloud(&source, &target, options).unwrap();
        miss_mm(&source, &found.target_from_source, &truth)
    };
    let plain = miss(&RegisterOptions::default());
    assert!(plain > 0.1, "dirt is meant to do harm, {plain} mm");
    for loss in [Loss::tukey_95(), Loss::GemanMcClure { scale: 2.0 }] {
        let robust = miss(&RegisterOptions { loss: Some(loss), ..Default::default() });
        assert!(robust < CLEAN_MM, "{loss:?} misses by {robust} mm");
    }
    // These never let go of an outlier: a bias of about 0.1 σ · influence / share remains.
    for loss in [Loss::huber_95(), Loss::cauchy_95()] {
        let robust = miss(&RegisterOptions { loss: Some(loss), ..Default::default() });
        assert!(robust < 5.0 * CLEAN_MM, "{loss:?} misses by {robust} mm");
    }
    let trimmed = miss(&RegisterOptions { keep_share: 0.85, ..Default::default() });
    assert!(trimmed < CLEAN_MM, "trimming misses by {trimmed} mm");
}

#[test]
fn points_beside_the_target_are_left_out() {
    let mut rng = scene::rng(42);
    let whole = scene::target(&mut rng, 150);
    let kept: Vec<usize> =
        (0..whole.points_mm.len()).filter(|&i| whole.points_mm[i].x < 0.0).collect();
    let normals = whole.normals.unwrap();
    let half = PointCloud::with_normals(
        kept.iter().map(|&i| whole.points_mm[i]).collect(),
        kept.iter().map(|&i| normals[i]).collect(),
    );
    let target = CloudTarget::new(&half).unwrap();
    let truth = small_pose();
    let source = scene::source(&mut rng, 5000, SIGMA_MM, &truth);
    let found = register_to_cloud(&source, &target, &RegisterOptions::default()).unwrap();
    let over = source.points_mm.iter().filter(|p| (truth * *p).x < 0.0).count();
    // A strip two spacings wide is a matter of taste: 2 · 0.67 of 88 mm are 1.5 %.
    assert!(found.used.abs_diff(over) < 100, "used {} of {over}", found.used);
    let miss = miss_mm(&source, &found.target_from_source, &truth);
    assert!(miss < 2.0 * CLEAN_MM, "misses by {miss} mm");
    let options = RegisterOptions { skip_beyond_border: false, ..Default::default() };
    let careless = register_to_cloud(&source, &target, &options);
    let miss = careless.map(|f| miss_mm(&source, &f.target_from_source, &truth));
    assert!(miss.is_err() || miss.unwrap() > 0.1, "the border is meant to matter");
}

#[test]
fn points_out_of_reach_take_no_part() {
    let mut rng = scene::rng(43);
    let target = CloudTarget::new(&scene::target(&mut rng, 150)).unwrap();
    let truth = small_pose();
    let mut source = scene::source(&mut rng, 5000, SIGMA_MM, &truth);
    source.normals = None;
    let n = source.points_mm.len();
    for k in 0..200_u32 {
        source.points_mm.push(Point3::from(Vector3::new(f64::from(k) / 10.0, 0.0, 40.0)));
    }
    let options = RegisterOptions { max_distance_mm: Some(5.0), ..Default::default() };
    let found = register_to_cloud(&source, &target, &options).unwrap();
    assert_eq!(found.used, n);
    source.points_mm.truncate(n);
    let miss = miss_mm(&source, &found.target_from_source, &truth);
    assert!(miss < CLEAN_MM, "misses by {miss} mm");
}

/// Points that a tilted start puts out of reach take part once the pose has come near enough.
#[test]
fn points_that_come_within_reach_take_part() {
    let mut rng = scene::rng(44);
    let target = CloudTarget::new(&scene::target(&mut rng, 150)).unwrap();
    let truth = small_pose();
    let source = scene::source(&mut rng, 5000, SIGMA_MM, &truth);
    // 44 mm · 0.06 are 2.6 mm at the border.
    let start = truth * Isometry3::rotation(Vector3::new(0.0, 0.06, 0.0));
    let reach_mm = 1.5;
    let options =
        RegisterOptions { start, max_distance_mm: Some(reach_mm), ..RegisterOptions::default() };
    let outside = source.points_mm.iter().filter(|p| (start * *p - truth * *p).norm() > 2.0);
    assert!(outside.count() > 500, "the start is meant to keep points out");
    let found = register_to_cloud(&source, &target, &options).unwrap();
    assert_eq!(found.used, source.points_mm.len());
    let miss = miss_mm(&source, &found.target_from_source, &truth);
    assert!(miss < CLEAN_MM, "misses by {miss} mm");
}
