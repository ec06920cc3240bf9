use std::io::Cursor;

use nalgebra::Point3;
use pose_icp::TriangleMesh;

use super::ShapeProblem;

/// Bytes before the count of triangles, with it, and of one triangle in a binary file.
const HEADER: usize = 80;
const PREAMBLE: usize = HEADER + 4;
const TRIANGLE: usize = 50;

/// Triangles of a binary or text STL, corners not yet joined.
pub(super) fn parse(bytes: &[u8]) -> Result<TriangleMesh, ShapeProblem> {
    let malformed = ShapeProblem::Malformed { format: "STL", line: None };
    if !bytes.trim_ascii_start().starts_with(b"solid") || binary_size(bytes) == Some(bytes.len()) {
        let size = binary_size(bytes).ok_or(ShapeProblem::Header { format: "STL" })?;
        if size > bytes.len() {
            let promised = (size - PREAMBLE) / TRIANGLE;
            return Err(ShapeProblem::TooShort { format: "STL", promised, bytes: bytes.len() });
        }
    }
    let mut cursor = Cursor::new(bytes);
    let triangles = stl_io::create_stl_reader(&mut cursor).map_err(|_| malformed.clone())?;
    let mut mesh = TriangleMesh::default();
    for triangle in triangles {
        let triangle = triangle.map_err(|_| malformed.clone())?;
        let first = u32::try_from(mesh.vertices_mm.len()).map_err(|_| malformed.clone())?;
        let corners = triangle.vertices.iter();
        mesh.vertices_mm
            .extend(corners.map(|v| Point3::new(v[0].into(), v[1].into(), v[2].into())));
        mesh.faces.push([first, first + 1, first + 2]);
    }
    if mesh.faces.is_empty() {
        return Err(ShapeProblem::Nothing { what: "triangles" });
    }
    Ok(mesh)
}

/// Size of a binary file with as many triangles as its header says.
fn binary_size(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER..PREAMBLE)?;
    let count = u32::from_le_bytes(count.try_into().expect("four bytes"));
    usize::try_from(count).ok()?.checked_mul(TRIANGLE)?.checked_add(PREAMBLE)
}
