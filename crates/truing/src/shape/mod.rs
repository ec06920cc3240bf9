//! Clouds and meshes out of files: PLY, STL, OBJ, and tables of coordinates.

mod obj;
mod ply;
mod problem;
mod stl;
mod table;

use std::path::Path;

use pose_icp::{PointCloud, TriangleMesh};

use crate::file::{MAX_BYTES, read_bytes};
use crate::{Error, InputFile};

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
    read_given(path).map(|(shape, _)| shape)
}

/// A shape, and the file that it was read from.
pub(crate) fn read_given(path: &Path) -> Result<(Shape, InputFile), Error> {
    let fail = |problem| Error::Shape { path: path.to_owned(), problem };
    let format = Format::of(path).map_err(fail)?;
    let bytes = read_bytes(path, MAX_BYTES).map_err(|problem| Error::not_read(path, problem))?;
    Ok((format.parse(&bytes).map_err(fail)?, InputFile::given(path, &bytes)))
}

/// What a file holds, by the ending of its name, which is looked at before the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Ply,
    Stl,
    Obj,
    Table,
}

impl Format {
    pub(crate) fn of(path: &Path) -> Result<Self, ShapeProblem> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let extension = extension.unwrap_or_default();
        match extension.as_str() {
            "ply" => Ok(Self::Ply),
            "stl" => Ok(Self::Stl),
            "obj" => Ok(Self::Obj),
            "xyz" | "txt" | "csv" | "asc" | "pts" => Ok(Self::Table),
            _ => Err(ShapeProblem::UnknownFormat { extension }),
        }
    }

    pub(crate) fn parse(self, bytes: &[u8]) -> Result<Shape, ShapeProblem> {
        if bytes.is_empty() {
            return Err(ShapeProblem::ZeroBytes);
        }
        match self {
            Self::Ply => ply::parse(bytes),
            Self::Stl => stl::parse(bytes).map(Shape::Mesh),
            Self::Obj => obj::parse(bytes).map(Shape::Mesh),
            Self::Table => table::parse(bytes).map(Shape::Cloud),
        }
    }
}
