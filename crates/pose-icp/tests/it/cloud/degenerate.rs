//! Input that must be refused, by name.

use least_squares::Loss;
use nalgebra::{Isometry3, Point3, Unit, Vector3};
use pose_icp::{
    CloudTarget, Freedom, Objective, PointCloud, RegisterError, RegisterOptions, Registration,
    register_to_cloud,
};

use super::scene;

fn run(
    source: &PointCloud,
    target: &PointCloud,
    options: &RegisterOptions,
) -> Result<Registration, RegisterError> {
    register_to_cloud(source, &CloudTarget::new(target)?, options)
}

fn clouds() -> (PointCloud, PointCloud) {
    let mut rng = scene::rng(60);
    let target = scene::target(&mut rng, 30);
    (scene::source(&mut rng, 200, 1e-3, &scene::small_pose()), target)
}

fn refusal(source: &PointCloud, target: &PointCloud, options: &RegisterOptions) -> String {
    run(source, target, options).unwrap_err().to_string()
}

#[test]
fn empty_clouds() {
    let (source, target) = clouds();
    let (none, options) = (PointCloud::default(), RegisterOptions::default());
    assert_eq!(refusal(&none, &target, &options), "the source holds no points");
    assert_eq!(refusal(&source, &none, &options), "the target holds no points");
}

#[test]
fn coordinates_that_are_no_lengths() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e10] {
        let (mut source, mut target) = clouds();
        source.points_mm[17].y = bad;
        let error = run(&source, &target, &RegisterOptions::default()).unwrap_err();
        assert!(matches!(error, RegisterError::InvalidPoint { index: 17, .. }), "{error}");
        target.points_mm[5].z = bad;
        let error = run(&source, &target, &RegisterOptions::default()).unwrap_err();
        assert!(matches!(error, RegisterError::InvalidPoint { index: 5, .. }), "{error}");
    }
}

#[test]
fn normals_that_are_none() {
    let (source, mut target) = clouds();
    target.normals.as_mut().unwrap()[3] = Unit::new_unchecked(Vector3::zeros());
    let error = run(&source, &target, &RegisterOptions::default()).unwrap_err();
    assert!(matches!(error, RegisterError::InvalidNormal { index: 3, .. }), "{error}");
    target.normals.as_mut().unwrap().pop();
    let error = run(&source, &target, &RegisterOptions::default()).unwrap_err();
    assert!(matches!(error, RegisterError::NormalCount { .. }), "{error}");
    target.normals = None;
    let error = run(&source, &target, &RegisterOptions::default()).unwrap_err();
    assert!(error.to_string().contains("needs normals of the target"), "{error}");
    let (mut source, target) = clouds();
    source.normals = None;
    let options = RegisterOptions { objective: Objective::Symmetric, ..Default::default() };
    let error = run(&source, &target, &options).unwrap_err();
    assert!(error.to_string().contains("needs normals of the source"), "{error}");
}

#[test]
fn fewer_points_than_unknowns() {
    let (mut source, target) = clouds();
    source.points_mm.truncate(5);
    source.normals = None;
    let error = run(&source, &target, &RegisterOptions::default()).unwrap_err();
    assert_eq!(error, RegisterError::TooFewPoints { got: 5, unknowns: 6 });
    let mut options = RegisterOptions::default();
    options.freedoms[5] = Freedom::Held;
    assert!(!matches!(run(&source, &target, &options), Err(RegisterError::TooFewPoints { .. })));
}

#[test]
fn one_point_many_times_leaves_rotations_free() {
    let (_, target) = clouds();
    let source = PointCloud::new(vec![Point3::new(1.0, 2.0, 0.1); 50]);
    let error = run(&source, &target, &RegisterOptions::default()).unwrap_err();
    let RegisterError::Undetermined { directions } = &error else { panic!("{error}") };
    assert_eq!(directions.len(), 5, "one row, fifty times: {error}");
}

#[test]
fn a_target_of_one_point_many_times_ends() {
    let (source, _) = clouds();
    let spot =
        PointCloud::with_normals(vec![Point3::origin(); 5000], vec![Vector3::z_axis(); 5000]);
    let error = run(&source, &spot, &RegisterOptions::default()).unwrap_err();
    assert!(
        matches!(error, RegisterError::NoOverlap { .. } | RegisterError::Undetermined { .. }),
        "{error}"
    );
}

#[test]
fn clouds_that_do_not_meet() {
    let (source, target) = clouds();
    let start = Isometry3::translation(0.0, 0.0, 500.0);
    let options =
        RegisterOptions { start, max_distance_mm: Some(10.0), ..RegisterOptions::default() };
    let message = refusal(&source, &target, &options);
    assert!(message.contains("only 0 of 200") && message.contains("10 mm"), "{message}");
}

#[test]
fn options_out_of_range() {
    let (source, target) = clouds();
    let default = RegisterOptions::default;
    let mut bad = Vec::new();
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        bad.push(RegisterOptions { tolerance_mm: value, ..default() });
        bad.push(RegisterOptions { sigma_mm: Some(value), ..default() });
        bad.push(RegisterOptions { max_distance_mm: Some(value), ..default() });
        bad.push(RegisterOptions { keep_share: value, ..default() });
        bad.push(RegisterOptions { loss: Some(Loss::Huber { scale: value }), ..default() });
        let freedoms = [Freedom::Prior { sigma: value }; 6];
        bad.push(RegisterOptions { freedoms, ..default() });
    }
    bad.push(RegisterOptions { start: Isometry3::translation(f64::NAN, 0.0, 0.0), ..default() });
    bad.push(RegisterOptions { keep_share: 1.5, ..default() });
    for options in bad {
        let error = run(&source, &target, &options).unwrap_err();
        assert!(matches!(error, RegisterError::InvalidOption { .. }), "{options:?}: {error}");
    }
}

#[test]
fn everything_held_is_a_check_of_the_start() {
    let (source, target) = clouds();
    let options = RegisterOptions { freedoms: [Freedom::Held; 6], ..Default::default() };
    let found = run(&source, &target, &options).unwrap();
    assert_eq!(found.target_from_source, Isometry3::identity());
    assert!(found.rms_mm > 0.1, "rms {}", found.rms_mm);
}
