use nalgebra::Point3;
use pose_icp::TriangleMesh;
use tobj::{LoadError, LoadOptions};

use super::ShapeProblem;

/// Triangles of all objects of a Wavefront file; larger polygons are cut into fans.
pub(super) fn parse(bytes: &[u8]) -> Result<TriangleMesh, ShapeProblem> {
    let options = LoadOptions { triangulate: true, ..LoadOptions::default() };
    let mut reader = bytes;
    // Colours and textures place nothing.
    let loaded = tobj::load_obj_buf(&mut reader, &options, |_| Err(LoadError::GenericFailure));
    let (objects, _) = loaded.map_err(|_| ShapeProblem::Malformed { format: "OBJ", line: None })?;
    let mut mesh = TriangleMesh::default();
    for object in objects {
        let first = u32::try_from(mesh.vertices_mm.len())
            .map_err(|_| ShapeProblem::Malformed { format: "OBJ", line: None })?;
        let positions = object.mesh.positions.chunks_exact(3);
        mesh.vertices_mm.extend(positions.map(|p| Point3::new(p[0], p[1], p[2])));
        for corners in object.mesh.indices.chunks_exact(3) {
            mesh.faces.push([0, 1, 2].map(|k| corners[k] + first));
        }
    }
    if mesh.faces.is_empty() {
        return Err(ShapeProblem::Nothing { what: "faces" });
    }
    Ok(mesh)
}
