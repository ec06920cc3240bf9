//! Meshes to register onto.

use nalgebra::Point3;
use pose_icp::TriangleMesh;

/// A block with a sloping top, 60 × 40 mm, its corner at the origin: no symmetry at all.
pub(crate) fn wedge() -> TriangleMesh {
    let vertices_mm = [
        [0.0, 0.0, 0.0],
        [60.0, 0.0, 0.0],
        [60.0, 40.0, 0.0],
        [0.0, 40.0, 0.0],
        [0.0, 0.0, 10.0],
        [60.0, 0.0, 18.0],
        [60.0, 40.0, 24.0],
        [0.0, 40.0, 16.0],
    ];
    let faces = vec![
        [0, 2, 1],
        [0, 3, 2],
        [0, 1, 5],
        [0, 5, 4],
        [1, 2, 6],
        [1, 6, 5],
        [2, 3, 7],
        [2, 7, 6],
        [3, 0, 4],
        [3, 4, 7],
        [4, 5, 6],
        [4, 6, 7],
    ];
    TriangleMesh { vertices_mm: vertices_mm.map(Point3::from).to_vec(), faces }
}

/// A flat sheet of `n × n` squares of 1 mm, each of two triangles, some squares left out.
pub(crate) fn sheet(n: u32, left_out: &[(u32, u32)]) -> TriangleMesh {
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let point = |k: u32| Point3::new(f64::from(k / (n + 1)), f64::from(k % (n + 1)), 0.0);
    let vertices_mm = (0..(n + 1) * (n + 1)).map(point).collect();
    let mut faces = Vec::new();
    for i in 0..n {
        for j in (0..n).filter(|&j| !left_out.contains(&(i, j))) {
            faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    TriangleMesh { vertices_mm, faces }
}
