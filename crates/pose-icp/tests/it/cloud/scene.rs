//! A wavy surface, 100 mm across, sampled twice.

use nalgebra::{Isometry3, Point3, Unit, Vector3};
use pose_icp::PointCloud;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

/// Half the edge of the target, mm.
const HALF_MM: f64 = 50.0;

/// The source keeps this far from the target's border, mm.
const INSET_MM: f64 = 6.0;

pub(crate) fn rng(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// Height and its slopes.
fn height(x: f64, y: f64) -> (f64, f64, f64) {
    let (sx, cx) = (x / 9.0 + 0.4).sin_cos();
    let (sy, cy) = (y / 13.0).sin_cos();
    let z = (x * x + y * y) / 400.0 + 0.8 * sx * cy + 1e-4 * x * x * y;
    let zx = x / 200.0 + 0.8 / 9.0 * cx * cy + 2e-4 * x * y;
    let zy = y / 200.0 - 0.8 / 13.0 * sx * sy + 1e-4 * x * x;
    (z, zx, zy)
}

pub(crate) fn on_surface(x: f64, y: f64) -> (Point3<f64>, Unit<Vector3<f64>>) {
    let (z, zx, zy) = height(x, y);
    (Point3::new(x, y, z), Unit::new_normalize(Vector3::new(-zx, -zy, 1.0)))
}

/// `per_side²` points on a jittered grid, with exact normals, in no order.
pub(crate) fn target(rng: &mut impl Rng, per_side: u32) -> PointCloud {
    let step = 2.0 * HALF_MM / f64::from(per_side);
    let mut at = |k: u32| -HALF_MM + step * (f64::from(k) + 0.5 + rng.random_range(-0.3..0.3));
    let mut sampled: Vec<_> = (0..per_side * per_side)
        .map(|k| (k.wrapping_mul(0x9e37_79b1), on_surface(at(k / per_side), at(k % per_side))))
        .collect();
    sampled.sort_by_key(|s| s.0);
    let (points_mm, normals) = sampled.into_iter().map(|s| s.1).unzip();
    PointCloud::with_normals(points_mm, normals)
}

/// Other points of the surface with noise along the normal, moved away by the inverse of `truth`.
pub(crate) fn source(
    rng: &mut impl Rng,
    n: usize,
    sigma_mm: f64,
    truth: &Isometry3<f64>,
) -> PointCloud {
    let noise = Normal::new(0.0, sigma_mm).unwrap();
    let range = HALF_MM - INSET_MM;
    let back = truth.inverse();
    let (points_mm, normals) = (0..n)
        .map(|_| {
            let (x, y) = (rng.random_range(-range..range), rng.random_range(-range..range));
            let (point, normal) = on_surface(x, y);
            let moved = back * (point + normal.into_inner() * noise.sample(rng));
            (moved, Unit::new_normalize(back * normal.into_inner()))
        })
        .unzip();
    PointCloud::with_normals(points_mm, normals)
}

/// The cloud with noise along its normals.
pub(crate) fn noisy(rng: &mut impl Rng, mut cloud: PointCloud, sigma_mm: f64) -> PointCloud {
    let noise = Normal::new(0.0, sigma_mm).unwrap();
    for (point, normal) in cloud.points_mm.iter_mut().zip(cloud.normals.as_ref().unwrap()) {
        *point += normal.into_inner() * noise.sample(rng);
    }
    cloud
}

/// About 1 mm and half a degree.
pub(crate) fn small_pose() -> Isometry3<f64> {
    Isometry3::new(Vector3::new(0.6, -0.45, 0.5), Vector3::new(4.4e-3, -3.5e-3, 6.1e-3))
}

/// Largest distance between the points at two poses, mm.
pub(crate) fn miss_mm(cloud: &PointCloud, a: &Isometry3<f64>, b: &Isometry3<f64>) -> f64 {
    cloud.points_mm.iter().map(|p| (a * p - b * p).norm()).fold(0.0, f64::max)
}
