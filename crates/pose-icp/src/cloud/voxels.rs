use nalgebra::{Point3, Unit, Vector3};

use super::error::{OptionName, RegisterError, Side};
use super::point_cloud::PointCloud;

/// Voxels along an edge of the cloud at most: positions of voxels must be exact integers.
const MAX_VOXELS: f64 = 9.0e15;

/// Replaces the points in each cube of edge `edge_mm` by their mean, ordered by cube.
///
/// Cubes are aligned with the axes and with the origin. Normals are averaged where there are any;
/// where they cancel, that of the cube's first point is taken.
///
/// # Errors
///
/// As [`PointCloud::check`]; [`RegisterError::InvalidOption`] for an edge that is not positive, or
/// too small for the coordinates.
pub fn thin_out(cloud: &PointCloud, edge_mm: f64) -> Result<PointCloud, RegisterError> {
    cloud.check(Side::Source)?;
    let largest = cloud.points_mm.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    if !(edge_mm > 0.0 && edge_mm.is_finite() && largest / edge_mm < MAX_VOXELS) {
        return Err(RegisterError::InvalidOption { option: OptionName::VoxelEdge, value: edge_mm });
    }
    let mut keyed: Vec<([i64; 3], usize)> =
        cloud.points_mm.iter().enumerate().map(|(i, p)| (voxel(p, edge_mm), i)).collect();
    keyed.sort_unstable();
    let members: Vec<Vec<usize>> =
        keyed.chunk_by(|a, b| a.0 == b.0).map(|c| c.iter().map(|k| k.1).collect()).collect();
    let points_mm = members.iter().map(|m| mean(&cloud.points_mm, m)).collect();
    let normals = cloud
        .normals
        .as_ref()
        .map(|normals| members.iter().map(|m| mean_normal(normals, m)).collect());
    Ok(PointCloud { points_mm, normals })
}

fn voxel(point: &Point3<f64>, edge_mm: f64) -> [i64; 3] {
    #[expect(clippy::cast_possible_truncation, reason = "checked to be below 2^53")]
    std::array::from_fn(|k| (point[k] / edge_mm).floor() as i64)
}

fn mean(points: &[Point3<f64>], members: &[usize]) -> Point3<f64> {
    let sum = members.iter().fold(Vector3::zeros(), |sum, &i| sum + points[i].coords);
    #[expect(clippy::cast_precision_loss, reason = "point counts are far below 2^53")]
    let count = members.len() as f64;
    Point3::from(sum / count)
}

fn mean_normal(normals: &[Unit<Vector3<f64>>], members: &[usize]) -> Unit<Vector3<f64>> {
    let first = normals[members[0]];
    let sum = members.iter().fold(Vector3::zeros(), |sum, &i| {
        let normal = normals[i].into_inner();
        if normal.dot(&first) < 0.0 { sum - normal } else { sum + normal }
    });
    Unit::try_new(sum, f64::MIN_POSITIVE).unwrap_or(first)
}
