//! Problems as files, and answers as one line each, the same for every peer.

use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Vector3};

/// Points stored as little-endian triples of `f64`.
pub fn read_points(path: &Path) -> Vec<Point3<f64>> {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let value = |chunk: &[u8]| f64::from_le_bytes(chunk.try_into().expect("eight bytes"));
    bytes
        .chunks_exact(24)
        .map(|p| Point3::new(value(&p[..8]), value(&p[8..16]), value(&p[16..])))
        .collect()
}

/// The pose that made the problem, target from source.
pub fn read_truth(path: &Path) -> Isometry3<f64> {
    pose(&read_numbers(path))
}

/// Angle in degrees and shift in mm of each start, and the start itself.
pub fn read_starts(path: &Path) -> Vec<([f64; 2], Isometry3<f64>)> {
    read_numbers(path).chunks_exact(14).map(|row| ([row[0], row[1]], pose(&row[2..]))).collect()
}

/// All numbers of a file.
pub fn read_numbers(path: &Path) -> Vec<f64> {
    let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    bytes.chunks_exact(8).map(|c| f64::from_le_bytes(c.try_into().expect("eight bytes"))).collect()
}

/// From a rotation matrix by rows and a translation.
fn pose(numbers: &[f64]) -> Isometry3<f64> {
    let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(&numbers[..9]));
    let translation = Vector3::new(numbers[9], numbers[10], numbers[11]);
    Isometry3::from_parts(translation.into(), rotation.into())
}

/// Largest distance, µm, between a source point at the true pose and at the one found.
pub fn error_um(
    source: &[Point3<f64>],
    truth: impl Fn(&Point3<f64>) -> Point3<f64>,
    found: impl Fn(&Point3<f64>) -> Point3<f64>,
) -> f64 {
    source.iter().map(|p| (truth(p) - found(p)).norm()).fold(0.0, f64::max) * 1e3
}
