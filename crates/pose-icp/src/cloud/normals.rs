use nalgebra::{Matrix3, Point3, SymmetricEigen, Unit, Vector3};
use rayon::prelude::*;

use super::error::{OptionName, RegisterError, Side};
use super::kd_tree::KdTree;
use super::point_cloud::check_points;

/// Fewest neighbours that span a plane.
const MIN_NEIGHBOURS: usize = 3;

/// Neighbours whose second principal spread is below this share of the first lie on a line: of
/// eigenvalues, so that it is a share of 1e-6 in length, where rounding begins.
const MIN_RELATIVE_VARIANCE: f64 = 1e-12;

/// Unit normals of a cloud, each from the plane through a point's nearest neighbours.
///
/// `neighbours` counts the point itself; 8 to 20 suit most scans. The plane is that of least
/// squares (Hoppe 1992). Signs: towards `viewpoint_mm` where it is given, else such that the
/// largest component is positive; registration does not depend on them.
///
/// # Errors
///
/// As [`PointCloud::check`](crate::PointCloud::check); [`RegisterError::InvalidOption`] for fewer than three neighbours or
/// more than there are points; [`RegisterError::NoPlane`] where neighbours lie on a line.
pub fn estimate_normals(
    points_mm: &[Point3<f64>],
    neighbours: usize,
    viewpoint_mm: Option<Point3<f64>>,
    side: Side,
) -> Result<Vec<Unit<Vector3<f64>>>, RegisterError> {
    if points_mm.is_empty() {
        return Err(RegisterError::Empty { side });
    }
    check_points(points_mm, side)?;
    if neighbours < MIN_NEIGHBOURS || neighbours > points_mm.len() {
        #[expect(clippy::cast_precision_loss, reason = "shown in a message")]
        let value = neighbours as f64;
        return Err(RegisterError::InvalidOption { option: OptionName::Neighbours, value });
    }
    let tree = KdTree::new(points_mm);
    let in_slots: Vec<Option<Vector3<f64>>> = tree
        .points()
        .par_iter()
        .map_with(Vec::new(), |nearest, point| {
            tree.nearest(point, neighbours, nearest);
            let normal = plane_normal(nearest.iter().map(|n| tree.points()[n.1 as usize]))?;
            Some(oriented(normal, point, viewpoint_mm))
        })
        .collect();
    let mut normals = vec![Vector3::z_axis(); points_mm.len()];
    for (normal, &index) in in_slots.iter().zip(tree.order()) {
        let index = index as usize;
        let normal = normal.ok_or(RegisterError::NoPlane { side, index, neighbours })?;
        normals[index] = Unit::new_normalize(normal);
    }
    Ok(normals)
}

/// Direction of least spread.
fn plane_normal(points: impl Iterator<Item = Point3<f64>> + Clone) -> Option<Vector3<f64>> {
    let (mut count, mut sum) = (0.0, Vector3::zeros());
    for point in points.clone() {
        count += 1.0;
        sum += point.coords;
    }
    let mean = sum / count;
    let scatter = points.fold(Matrix3::zeros(), |scatter, point| {
        let offset = point.coords - mean;
        scatter + offset * offset.transpose()
    });
    let eigen = SymmetricEigen::new(scatter);
    let least = eigen.eigenvalues.imin();
    let largest = eigen.eigenvalues.max();
    let middle = eigen.eigenvalues.sum() - largest - eigen.eigenvalues[least];
    (middle > MIN_RELATIVE_VARIANCE * largest).then(|| eigen.eigenvectors.column(least).into())
}

fn oriented(
    normal: Vector3<f64>,
    point: &Point3<f64>,
    viewpoint: Option<Point3<f64>>,
) -> Vector3<f64> {
    let towards = match viewpoint {
        Some(viewpoint) => normal.dot(&(viewpoint - point)),
        None => normal[normal.iamax()],
    };
    if towards < 0.0 { -normal } else { normal }
}
