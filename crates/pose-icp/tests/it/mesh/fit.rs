//! Registration onto triangles.

use nalgebra::{Isometry3, Point3, Vector3};
use pose_icp::{
    Holes, MeshTarget, Objective, PointCloud, RegisterError, RegisterOptions, register_to_mesh,
    sample_surface,
};

use super::shapes::{sheet, wedge};

/// 60 mm · 2⁻⁵² · about 1000 operations.
const EXACT_TOL_MM: f64 = 1e-11;

fn truth() -> Isometry3<f64> {
    Isometry3::new(Vector3::new(0.3, -0.4, 0.2), Vector3::new(4e-3, -6e-3, 5e-3))
}

#[test]
fn finds_a_body_from_points_of_its_faces() {
    let target = MeshTarget::new(&wedge(), Holes::Refuse).unwrap();
    let mut source = sample_surface(&wedge(), 4000).unwrap();
    source.normals = None;
    source.points_mm.iter_mut().for_each(|p| *p = truth().inverse() * *p);
    for objective in [Objective::PointToPlane, Objective::PointToPoint] {
        let options = RegisterOptions { objective, max_iterations: 2000, ..Default::default() };
        let found = register_to_mesh(&source, &target, &options).unwrap();
        let miss = |p: &Point3<f64>| (found.target_from_source * p - truth() * p).norm();
        let worst = source.points_mm.iter().map(miss).fold(0.0, f64::max);
        // Feet slide with the point, so that point-to-point creeps here too: to its tolerance
        // over what a step leaves undone.
        let bound = if objective == Objective::PointToPlane { EXACT_TOL_MM } else { 1e-3 };
        assert!(worst < bound, "{objective:?} misses by {worst:e} mm");
        assert!(found.observability.unwrap().weak.is_empty());
    }
}

#[test]
fn sampled_points_lie_on_their_faces_and_cover_the_area() {
    let cloud = sample_surface(&wedge(), 4000).unwrap();
    assert!(cloud.points_mm.len() > 3500 && cloud.points_mm.len() < 4500);
    let centroid = cloud.points_mm.iter().fold(Vector3::zeros(), |s, p| s + p.coords);
    #[expect(clippy::cast_precision_loss, reason = "a small count")]
    let centroid = centroid / cloud.points_mm.len() as f64;
    assert!((centroid.x - 30.0).abs() < 2.0 && (centroid.y - 20.0).abs() < 2.0, "{centroid}");
    let target = MeshTarget::new(&wedge(), Holes::Refuse).unwrap();
    let held = RegisterOptions { freedoms: [pose_icp::Freedom::Held; 6], ..Default::default() };
    let found = register_to_mesh(&cloud, &target, &held).unwrap();
    assert!(found.rms_mm < EXACT_TOL_MM && found.used == cloud.points_mm.len());
}

#[test]
fn a_sheet_leaves_its_plane_free() {
    let target = MeshTarget::new(&sheet(30, &[]), Holes::Refuse).unwrap();
    let grid = |k: i32| f64::from(k % 20) + 5.0;
    let points = (0..400).map(|k| Point3::new(grid(k), grid(k / 20), 0.1)).collect();
    let error = register_to_mesh(&PointCloud::new(points), &target, &RegisterOptions::default())
        .unwrap_err();
    let RegisterError::Undetermined { directions } = &error else { panic!("{error}") };
    assert_eq!(directions.len(), 3);
}

#[test]
fn points_beside_a_sheet_and_over_its_holes_are_left_out() {
    let left_out: Vec<_> = (10..20).flat_map(|i| (10..20).map(move |j| (i, j))).collect();
    let target = MeshTarget::new(&sheet(30, &left_out), Holes::Skip).unwrap();
    // Half a square off the lattice, 40 × 40: 30 × 30 over the sheet, 10 × 10 of them over the hole.
    let at = |k: i32| f64::from(k % 40) - 4.5;
    let points = (0..1600).map(|k| Point3::new(at(k), at(k / 40), 0.1)).collect();
    let options = RegisterOptions { freedoms: [pose_icp::Freedom::Held; 6], ..Default::default() };
    let found = register_to_mesh(&PointCloud::new(points), &target, &options).unwrap();
    assert_eq!(found.used, 800);
    assert!((found.rms_mm - 0.1).abs() < 1e-12);
}
