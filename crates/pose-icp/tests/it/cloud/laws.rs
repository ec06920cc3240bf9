//! What must hold whatever the numbers are.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use pose_icp::{
    CloudTarget, Objective, PointCloud, RegisterError, RegisterOptions, Registration,
    register_to_cloud,
};

use super::scene::{self, miss_mm, small_pose};

/// The stop test allows this much motion, and Gauss-Newton squares what is left.
const TOLERANCE_MM: f64 = 1e-6;

/// 100 mm · 2⁻⁵² · about 500 operations on the way from sums to a pose.
const EXACT_TOL_MM: f64 = 1e-11;

fn fit(source: &PointCloud, target: &PointCloud, options: &RegisterOptions) -> Registration {
    register_to_cloud(source, &CloudTarget::new(target).unwrap(), options).unwrap()
}

#[test]
fn finds_a_cloud_in_itself() {
    let mut rng = scene::rng(10);
    let target = scene::target(&mut rng, 70);
    let truth = small_pose();
    for objective in [Objective::PointToPlane, Objective::PointToPoint, Objective::Symmetric] {
        let mut source = target.clone();
        source.points_mm.iter_mut().for_each(|p| *p = truth.inverse() * *p);
        let turn = |n: &Vector3<f64>| nalgebra::Unit::new_normalize(truth.inverse() * n);
        source.normals = source.normals.map(|n| n.iter().map(|n| turn(n)).collect());
        let options = RegisterOptions { objective, max_iterations: 500, ..Default::default() };
        let found = fit(&source, &target, &options).target_from_source;
        let miss = miss_mm(&source, &found, &truth);
        assert!(miss < EXACT_TOL_MM, "{objective:?} misses by {miss:e} mm");
    }
}

#[test]
fn same_bits_on_one_thread_and_on_two() {
    let mut rng = scene::rng(11);
    let target = scene::target(&mut rng, 200);
    let source = scene::source(&mut rng, 70_000, 2e-3, &small_pose());
    let options = RegisterOptions {
        loss: Some(least_squares::Loss::tukey_95()),
        keep_share: 0.9,
        ..Default::default()
    };
    let [one, two, three, eight] = [1, 2, 3, 8].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fit(&source, &target, &options))
    });
    // Equal fields include every bit of pose, covariance and singular values.
    assert_eq!(one, two);
    assert_eq!(one, three);
    assert_eq!(one, eight);
}

#[test]
fn same_bits_on_any_number_of_threads_with_half_an_overlap_and_noise_on_both_sides() {
    let mut rng = scene::rng(17);
    let whole = scene::target(&mut rng, 200);
    let whole = scene::noisy(&mut rng, whole, 2e-2);
    let normals = whole.normals.unwrap();
    let (points_mm, normals) = whole
        .points_mm
        .into_iter()
        .zip(normals)
        .filter(|(point, _)| point.x < 5.0)
        .unzip::<_, _, Vec<_>, Vec<_>>();
    let target = PointCloud::with_normals(points_mm, normals);
    let source = scene::source(&mut rng, 70_000, 2e-2, &small_pose());
    let [one, two, three, eight] = [1, 2, 3, 8].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fit(&source, &target, &RegisterOptions::default()))
    });
    assert_eq!(one, two);
    assert_eq!(one, three);
    assert_eq!(one, eight);
    let over = source.points_mm.iter().filter(|p| (small_pose() * *p).x < 5.0).count();
    // A strip is a matter of taste: up to the diagonal of a leaf, 2.3 · √2 spacings of 0.5 mm, of 88 mm.
    assert!(one.used.abs_diff(over) < 1300, "used {} of {over}", one.used);
}

#[test]
fn a_motion_of_both_frames_moves_the_answer_with_them() {
    let mut rng = scene::rng(12);
    let target = scene::target(&mut rng, 60);
    let source = scene::source(&mut rng, 3000, 2e-3, &small_pose());
    let frame = Isometry3::new(Vector3::new(900.0, -300.0, 70.0), Vector3::new(0.4, -1.1, 2.0));
    let turned = PointCloud::with_normals(
        target.points_mm.iter().map(|p| frame * p).collect(),
        target.normals.as_ref().unwrap().iter().map(|n| frame * n).collect(),
    );
    let here = fit(&source, &target, &RegisterOptions::default());
    let start = frame;
    let there = fit(&source, &turned, &RegisterOptions { start, ..Default::default() });
    // The trees are cut differently, so levels and sums differ; the fixed point is the same.
    let miss = miss_mm(&source, &(frame * here.target_from_source), &there.target_from_source);
    assert!(miss < 2.0 * TOLERANCE_MM, "frames disagree by {miss:e} mm");
    assert!((here.rms_mm / there.rms_mm - 1.0).abs() < 1e-6);
}

#[test]
fn results_follow_the_unit_of_length() {
    let mut rng = scene::rng(13);
    let target = scene::target(&mut rng, 60);
    let source = scene::source(&mut rng, 3000, 2e-3, &small_pose());
    // A power of two, so that scaling itself rounds nothing.
    let scale = 1024.0;
    let scaled = |cloud: &PointCloud| PointCloud {
        points_mm: cloud.points_mm.iter().map(|p| p * scale).collect(),
        normals: cloud.normals.clone(),
    };
    let small = fit(&source, &target, &RegisterOptions::default());
    let options =
        RegisterOptions { tolerance_mm: TOLERANCE_MM * scale, ..RegisterOptions::default() };
    let large = fit(&scaled(&source), &scaled(&target), &options);
    let shift = large.target_from_source.translation.vector / scale
        - small.target_from_source.translation.vector;
    assert!(shift.norm() < TOLERANCE_MM, "translation {shift}");
    let turn = large.target_from_source.rotation.angle_to(&small.target_from_source.rotation);
    assert!(turn * 50.0 < TOLERANCE_MM, "rotation {turn:e} rad");
    assert!((large.sigma_mm / scale / small.sigma_mm - 1.0).abs() < 1e-9);
    assert_eq!(large.iterations, small.iterations);
}

#[test]
fn ends_where_it_starts_when_that_is_the_answer() {
    let mut rng = scene::rng(14);
    let target = scene::target(&mut rng, 60);
    let source = scene::source(&mut rng, 3000, 2e-3, &small_pose());
    let target = CloudTarget::new(&target).unwrap();
    let first = register_to_cloud(&source, &target, &RegisterOptions::default()).unwrap();
    let options = RegisterOptions { start: first.target_from_source, ..Default::default() };
    let again = register_to_cloud(&source, &target, &options).unwrap();
    let miss = miss_mm(&source, &first.target_from_source, &again.target_from_source);
    assert!(miss < 2.0 * TOLERANCE_MM, "moved by {miss:e} mm");
}

#[test]
fn point_to_point_creeps_where_point_to_plane_arrives() {
    let mut rng = scene::rng(15);
    let target = CloudTarget::new(&scene::target(&mut rng, 60)).unwrap();
    let source = scene::source(&mut rng, 3000, 2e-3, &small_pose());
    let options =
        |objective| RegisterOptions { objective, max_iterations: 20, ..Default::default() };
    let plane = register_to_cloud(&source, &target, &options(Objective::PointToPlane)).unwrap();
    assert!(plane.iterations <= 8, "{} iterations", plane.iterations);
    let point = register_to_cloud(&source, &target, &options(Objective::PointToPoint));
    let Err(RegisterError::NotConverged { best }) = point else { panic!("{point:?}") };
    assert_eq!(best.iterations, 20);
    assert!(best.last_motion_mm > TOLERANCE_MM);
}

#[test]
fn a_quarter_turn_about_the_pivot_is_found_from_a_start_near_it() {
    let mut rng = scene::rng(16);
    let target = scene::target(&mut rng, 60);
    let truth = Isometry3::from_parts(
        Vector3::new(400.0, 20.0, -70.0).into(),
        UnitQuaternion::from_euler_angles(0.3, -0.8, 2.5),
    );
    let source = scene::source(&mut rng, 3000, 0.0, &truth);
    let start = small_pose() * truth;
    let found = fit(&source, &target, &RegisterOptions { start, ..Default::default() });
    // A tangent plane leaves the surface by κd²/2; d reaches 1.2 mm between points 1.7 mm apart,
    // κ 0.015 per mm: 11 µm for the worst point.
    let miss = miss_mm(&source, &found.target_from_source, &truth);
    assert!(miss < 0.011, "misses by {miss:e} mm");
    assert_eq!(found.used, source.points_mm.len());
}

/// Neighbours that are kept while the pose moves must still be the nearest in the end: looked up anew from
/// the answer they leave the same residuals.
#[test]
fn an_answer_is_that_of_neighbours_looked_up_anew() {
    let mut rng = scene::rng(18);
    let target = scene::target(&mut rng, 150);
    let source = scene::source(&mut rng, 3000, 2e-3, &small_pose());
    let options = RegisterOptions {
        objective: Objective::PointToPoint,
        max_iterations: 1000,
        ..Default::default()
    };
    let found = fit(&source, &target, &options);
    let start = found.target_from_source;
    let again = fit(&source, &target, &RegisterOptions { start, ..options });
    // At a minimum residuals change in second order: the motion that the stop test allows is nothing.
    assert!(
        (again.rms_mm - found.rms_mm).abs() < TOLERANCE_MM,
        "{} {}",
        again.rms_mm,
        found.rms_mm
    );
    assert!(miss_mm(&source, &again.target_from_source, &start) < 100.0 * TOLERANCE_MM);
}
