//! A scan of half a face, with dust on it, onto the whole face.

use least_squares::Loss;
use nalgebra::{Isometry3, Point3, Vector3};
use pose_icp::{
    CloudTarget, PointCloud, RegisterError, RegisterOptions, Side, estimate_normals,
    register_to_cloud,
};

/// Height of the face, mm, 60 mm across.
fn height(x: f64, y: f64) -> f64 {
    2.0 * (x / 5.0).sin() * (y / 6.0).cos() + x * y / 80.0
}

fn main() -> Result<(), RegisterError> {
    let grid = |k: i32| f64::from(k % 151 - 75) * 0.4;
    let face: Vec<_> = (0..151 * 151)
        .map(|k| (grid(k), grid(k / 151)))
        .map(|(x, y)| Point3::new(x, y, height(x, y)))
        .collect();
    let normals = estimate_normals(&face, 12, None, Side::Target)?;
    let target = CloudTarget::new(&PointCloud::with_normals(face, normals))?;

    // The scanner saw x > 5 mm and 10 mm more than there is; every tenth point is dust.
    let truth = Isometry3::new(Vector3::new(0.4, -0.3, 0.2), Vector3::new(2e-3, 3e-3, -4e-3));
    let seen = (0..4000).map(|k| {
        let (x, y) = (5.0 + f64::from(k % 80) * 0.43, f64::from(k / 80 - 25) * 1.1);
        let dust = if k % 10 == 0 { 0.5 + f64::from(k % 7) / 5.0 } else { 0.0 };
        truth.inverse() * Point3::new(x, y, height(x, y) + dust)
    });
    let scan = PointCloud::new(seen.collect());

    let options = RegisterOptions { loss: Some(Loss::tukey_95()), ..RegisterOptions::default() };
    let found = register_to_cloud(&scan, &target, &options)?;
    let miss = found.target_from_source.inverse() * truth;
    // Normals from neighbours 0.4 mm apart on curvatures of 0.1 per mm: some micrometres.
    assert!(miss.translation.vector.norm() < 0.02, "misses by {}", miss.translation.vector);
    assert!(miss.rotation.angle() < 5e-4);
    assert!(found.used < scan.points_mm.len(), "points beside the face take no part");
    Ok(())
}
