use nalgebra::{Point3, Unit, Vector3};

use super::triangles::TriangleMesh;
use crate::{PointCloud, RegisterError, Side};

/// Points of a mesh's surface with the normals of its faces, for use as a source.
///
/// Each face is cut into n² equal parts, as many as it takes for about `n_points` in all, and one
/// at least; the centroid of each part is a point.
///
/// # Errors
///
/// As [`TriangleMesh::check`].
pub fn sample_surface(mesh: &TriangleMesh, n_points: usize) -> Result<PointCloud, RegisterError> {
    mesh.check(Side::Source)?;
    let total: f64 = (0..mesh.faces.len()).map(|f| mesh.area_vector(f).norm()).sum();
    #[expect(clippy::cast_precision_loss, reason = "point counts are far below 2^53")]
    let per_point = total / n_points.max(1) as f64;
    let mut points_mm = Vec::new();
    let mut normals = Vec::new();
    for face in 0..mesh.faces.len() {
        let area = mesh.area_vector(face);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most the root of a point count"
        )]
        let cuts = (area.norm() / per_point).sqrt().round().max(1.0) as u32;
        let before = points_mm.len();
        cut(&mesh.corners(face), cuts, &mut points_mm);
        normals.resize(points_mm.len(), Unit::new_normalize(area));
        debug_assert_eq!(points_mm.len() - before, (cuts * cuts) as usize);
    }
    Ok(PointCloud::with_normals(points_mm, normals))
}

/// Centroids of the n² similar triangles that a triangle falls into.
fn cut(corners: &[Point3<f64>; 3], n: u32, points: &mut Vec<Point3<f64>>) {
    let [a, b, c] = corners;
    let (u, v): (Vector3<f64>, Vector3<f64>) = ((b - a) / f64::from(n), (c - a) / f64::from(n));
    for i in 0..n {
        for j in 0..n - i {
            let corner = a + u * f64::from(i) + v * f64::from(j);
            points.push(corner + (u + v) / 3.0);
            if i + j + 1 < n {
                points.push(corner + (u + v) * (2.0 / 3.0));
            }
        }
    }
}
