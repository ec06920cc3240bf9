//! The classical iteration: document \[D\], (4)–(7).

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::model_cloud::ModelCloud;

/// Where a level ended.
#[derive(Clone, Debug)]
pub(super) struct Level {
    /// The transform after it: ideal from real.
    pub(super) ideal_from_real: Isometry3<f64>,
    /// Passes, each a search and a fit.
    pub(super) iterations: usize,
    /// Distances from the model points, under the transform above.
    pub(super) distances_mm: Vec<f64>,
    /// Whether all of them are below the tolerance.
    pub(super) reached: bool,
}

/// Repeats «nearest model points, best rigid transform» until all points are nearer than the
/// tolerance, (12), or passes run out.
pub(super) fn iterate(
    cloud: &ModelCloud,
    real_mm: &[Point3<f64>],
    start: Isometry3<f64>,
    tolerance_mm: f64,
    max_iterations: usize,
) -> Level {
    let mut level =
        Level { ideal_from_real: start, iterations: 0, distances_mm: Vec::new(), reached: false };
    loop {
        let moved: Vec<_> = real_mm.iter().map(|m| level.ideal_from_real * m).collect();
        // A cloud without points has no pairs, and a start without them is where it ends.
        let pairs: Vec<_> =
            moved.iter().filter_map(|p| cloud.nearest(p).map(|q| (*p, q))).collect();
        level.distances_mm = pairs.iter().map(|(p, q)| (p - q).norm()).collect();
        level.reached = level.distances_mm.len() == real_mm.len()
            && level.distances_mm.iter().all(|d| *d < tolerance_mm);
        if level.reached || level.iterations == max_iterations || pairs.is_empty() {
            return level;
        }
        level.ideal_from_real = best_transform(&pairs) * level.ideal_from_real;
        level.iterations += 1;
    }
}

/// The rigid transform of least `Σ |T p − q|²`, by singular value decomposition (Arun 1987).
fn best_transform(pairs: &[(Point3<f64>, Point3<f64>)]) -> Isometry3<f64> {
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let n = pairs.len() as f64;
    let from: Vector3<f64> = pairs.iter().map(|(p, _)| p.coords).sum::<Vector3<f64>>() / n;
    let to: Vector3<f64> = pairs.iter().map(|(_, q)| q.coords).sum::<Vector3<f64>>() / n;
    let spread: Matrix3<f64> =
        pairs.iter().map(|(p, q)| (q.coords - to) * (p.coords - from).transpose()).sum();
    let svd = spread.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
        return Isometry3::from_parts(Translation3::from(to - from), UnitQuaternion::identity());
    };
    // Turned, not mirrored: the least singular value, the last, takes the sign.
    let signs = Vector3::new(1.0, 1.0, (u * v_t).determinant().signum());
    let rotation = Rotation3::from_matrix_unchecked(u * Matrix3::from_diagonal(&signs) * v_t);
    let rotation = UnitQuaternion::from(rotation);
    Isometry3::from_parts(Translation3::from(to - rotation * from), rotation)
}
