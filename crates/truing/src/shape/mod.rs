//! Clouds and meshes out of files: PLY, STL, OBJ, and tables of coordinates.

mod obj;
mod ply;
mod problem;
mod stl;
mod table;

use std::path::{Path, PathBuf};

use pose_icp::{PointCloud, TriangleMesh};

use crate::Error;

pub use problem::ShapeProblem;

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Points, with normals where the file has them.
    Cloud(PointCloud),
    /// Triangles.
    Mesh(TriangleMesh),
}

/// Reads a cloud or a mesh; lengths in the file are mm.
///
/// The ending of the name says what it is: `.ply`, `.stl`, `.obj`, or a table of coordinates in
/// `.xyz`, `.txt`, `.csv`, `.asc` or `.pts`.
///
/// # Errors
///
/// [`Error::NotRead`]; [`Error::Shape`] with the line, where there are lines.
pub fn read_shape(path: &Path) -> Result<Shape, Error> {
    let bytes = std::fs::read(path)
        .map_err(|e| Error::NotRead { path: path.to_owned(), reason: e.kind() })?;
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    parse(extension.as_deref().unwrap_or(""), &bytes)
        .map_err(|problem| Error::Shape { path: PathBuf::from(path), problem })
}

fn parse(extension: &str, bytes: &[u8]) -> Result<Shape, ShapeProblem> {
    if bytes.is_empty() {
        return Err(ShapeProblem::ZeroBytes);
    }
    match extension {
        "ply" => ply::parse(bytes),
        "stl" => stl::parse(bytes).map(Shape::Mesh),
        "obj" => obj::parse(bytes).map(Shape::Mesh),
        "xyz" | "txt" | "csv" | "asc" | "pts" => table::parse(bytes).map(Shape::Cloud),
        _ => Err(ShapeProblem::UnknownFormat { extension: extension.to_owned() }),
    }
}
