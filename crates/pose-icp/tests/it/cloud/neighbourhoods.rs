//! Normals from neighbours, thinning.

use nalgebra::{Point3, Vector3};
use pose_icp::{
    CloudTarget, PointCloud, RegisterError, RegisterOptions, Side, estimate_normals,
    register_to_cloud, thin_out,
};

use super::scene;

#[test]
fn normals_follow_the_surface() {
    let mut rng = scene::rng(50);
    let cloud = scene::target(&mut rng, 150);
    let above = Point3::new(0.0, 0.0, 1e4);
    let found = estimate_normals(&cloud.points_mm, 12, Some(above), Side::Target).unwrap();
    // Twelve neighbours reach 1.5 mm; curvatures are up to 0.8/9² + 1/200 = 0.015 per mm, so that a
    // lopsided neighbourhood, as on the border, tilts the plane by up to 1.5 · 0.015.
    for (found, exact) in found.iter().zip(cloud.normals.unwrap()) {
        assert!(found.angle(&exact) < 0.023, "off by {} rad", found.angle(&exact));
        assert!(found.z > 0.0);
    }
}

#[test]
fn estimated_normals_register_as_well_as_exact_ones() {
    let mut rng = scene::rng(51);
    let mut cloud = scene::target(&mut rng, 150);
    cloud.normals = Some(estimate_normals(&cloud.points_mm, 12, None, Side::Target).unwrap());
    let target = CloudTarget::new(&cloud).unwrap();
    let truth = scene::small_pose();
    let source = scene::source(&mut rng, 5000, 2e-3, &truth);
    let found = register_to_cloud(&source, &target, &RegisterOptions::default()).unwrap();
    let miss = scene::miss_mm(&source, &found.target_from_source, &truth);
    // Tilts of 0.01 rad over half a spacing of 0.67 mm: 3 µm a point, like the noise.
    assert!(miss < 4e-3, "misses by {miss} mm");
}

#[test]
fn points_on_a_line_have_no_normal() {
    let line: Vec<_> =
        (0..20).map(|k| Point3::new(f64::from(k), 2.0 * f64::from(k), 0.0)).collect();
    let error = estimate_normals(&line, 5, None, Side::Source).unwrap_err();
    assert!(matches!(error, RegisterError::NoPlane { .. }), "{error}");
    let error = estimate_normals(&line, 2, None, Side::Source).unwrap_err();
    assert!(error.to_string().contains("neighbours"), "{error}");
    let error = estimate_normals(&line, 21, None, Side::Source).unwrap_err();
    assert!(error.to_string().contains("neighbours"), "{error}");
}

#[test]
fn thinning_keeps_means_and_leaves_one_point_a_cube() {
    let mut rng = scene::rng(52);
    let cloud = scene::target(&mut rng, 100);
    let thin = thin_out(&cloud, 5.0).unwrap();
    assert!(thin.points_mm.len() >= 400 && thin.points_mm.len() < 1200);
    #[expect(clippy::cast_possible_truncation, reason = "ten cubes each way")]
    let key = |p: &Point3<f64>| [0, 1, 2].map(|k| (p[k] / 5.0).floor() as i32);
    let mut keys: Vec<_> = thin.points_mm.iter().map(key).collect();
    keys.dedup();
    assert_eq!(keys.len(), thin.points_mm.len());
    for (at, normal) in thin.points_mm.iter().zip(thin.normals.as_ref().unwrap()) {
        let members: Vec<_> = cloud.points_mm.iter().filter(|p| key(p) == key(at)).collect();
        let sum = members.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords);
        #[expect(clippy::cast_precision_loss, reason = "a small count")]
        let mean = sum / members.len() as f64;
        assert!((at.coords - mean).norm() < 1e-12);
        // Slopes change by at most 0.015 · 5·√2 / 2 within a cube.
        assert!(normal.angle(&scene::on_surface(at.x, at.y).1) < 0.06);
    }
}

#[test]
fn a_cube_that_holds_everything_gives_the_centroid() {
    let cloud = PointCloud::new(vec![Point3::new(1.0, 2.0, 3.0), Point3::new(3.0, 2.0, 1.0)]);
    assert_eq!(thin_out(&cloud, 100.0).unwrap().points_mm, vec![Point3::new(2.0, 2.0, 2.0)]);
    for edge_mm in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-300] {
        let error = thin_out(&cloud, edge_mm).unwrap_err();
        assert!(matches!(error, RegisterError::InvalidOption { .. }), "{edge_mm}: {error}");
    }
}
