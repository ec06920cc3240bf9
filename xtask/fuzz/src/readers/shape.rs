//! Clouds and meshes, in every format that is read.

use std::fs;

use tempfile::TempDir;
use truing::{Shape, read_shape};

pub(super) fn read(bytes: &[u8]) {
    let folder = TempDir::new().expect("a temporary folder can be made");
    for name in ["shape.ply", "shape.stl", "shape.obj", "shape.xyz"] {
        let path = folder.path().join(name);
        fs::write(&path, bytes).expect("the folder can be written to");
        match read_shape(&path) {
            Ok(Shape::Cloud(cloud)) => assert!(!cloud.points_mm.is_empty()),
            Ok(Shape::Mesh(mesh)) => {
                let n = mesh.vertices_mm.len();
                let within = |corner: &u32| usize::try_from(*corner).is_ok_and(|c| c < n);
                assert!(mesh.faces.iter().flatten().all(within), "a corner that is not there");
            }
            Err(error) => assert_eq!(error.exit_code(), 2, "{error}"),
        }
    }
}
