use std::fmt;

use crate::case::{Problem, quote};

/// What is wrong with a file of points or triangles.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ShapeProblem {
    /// The file is empty.
    ZeroBytes,
    /// The name's ending says nothing known.
    UnknownFormat {
        /// The ending, without its dot.
        extension: String,
    },
    /// The header cannot be read.
    Header {
        /// Which format it should be.
        format: &'static str,
    },
    /// The content breaks off, or is not what its header says.
    Malformed {
        /// Which format it should be.
        format: &'static str,
        /// Line from 1, where it is known.
        line: Option<usize>,
    },
    /// A table of coordinates that is no text.
    NotText {
        /// Line, from 1.
        line: usize,
        /// Character, from 1.
        column: usize,
        /// Why it is none.
        problem: Box<Problem>,
    },
    /// The header promises more than the file can hold.
    TooShort {
        /// Which format it should be.
        format: &'static str,
        /// Elements promised.
        promised: usize,
        /// Bytes that there are.
        bytes: usize,
    },
    /// A cell that is no finite number.
    NotANumber {
        /// Line, from 1.
        line: usize,
        /// Cell, from 1.
        column: usize,
        /// What is there.
        found: String,
    },
    /// A number that can be read in two ways.
    TwoWays {
        /// Line, from 1.
        line: usize,
        /// Cell, from 1.
        column: usize,
        /// What is there.
        found: String,
    },
    /// A heading with another unit than mm.
    OtherUnit {
        /// Line, from 1.
        line: usize,
        /// The heading.
        found: String,
    },
    /// A line with the wrong number of cells.
    Cells {
        /// Line, from 1.
        line: usize,
        /// Cells expected.
        expected: usize,
        /// Cells found.
        found: usize,
    },
    /// A table whose columns are not 3 coordinates, or these and a normal.
    Columns {
        /// Line, from 1.
        line: usize,
        /// Cells found.
        found: usize,
    },
    /// A normal without a length.
    NoNormal {
        /// Place of the point, from 0.
        index: usize,
    },
    /// A face that is not made of at least three vertices which exist.
    Face {
        /// Place of the face, from 0.
        index: usize,
    },
    /// There is not a single point or triangle in it.
    Nothing {
        /// What is missing.
        what: &'static str,
    },
}

impl fmt::Display for ShapeProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ZeroBytes => write!(f, "the file is empty (0 bytes)"),
            Self::UnknownFormat { extension } => write!(
                f,
                "unknown ending {}; expected .ply, .stl, .obj, .xyz, .txt, .csv, .asc or .pts",
                quote(extension)
            ),
            Self::Header { format } => write!(f, "the header is not that of a {format} file"),
            Self::NotText { line, column, problem } => write!(
                f,
                "line {line}, column {column}: {problem}; the format is one point a line, \
                 x, y, z or x, y, z, nx, ny, nz in mm"
            ),
            Self::Malformed { format, line: Some(line) } => {
                write!(f, "line {line} does not follow the {format} format")
            }
            Self::Malformed { format, line: None } => {
                write!(f, "the content breaks off or does not follow the {format} format")
            }
            Self::TooShort { format, promised, bytes } => write!(
                f,
                "the {format} header promises {promised} elements, more than the {bytes} bytes of \
                 the file can hold"
            ),
            Self::NotANumber { line, column, found } => write!(
                f,
                "line {line}, column {column}: expected a finite number, found {}",
                quote(found)
            ),
            Self::TwoWays { line, column, found } => write!(
                f,
                "line {line}, column {column}: the point or comma in {} can be read in two ways; \
                 write all decimals with a point",
                quote(found)
            ),
            Self::OtherUnit { line, found } => write!(
                f,
                "line {line}: the heading {} says another unit; give coordinates in mm",
                quote(found)
            ),
            Self::Cells { line, expected, found } => {
                write!(f, "line {line}: expected {expected} cells as before, found {found}")
            }
            Self::Columns { line, found } => write!(
                f,
                "line {line}: expected x, y, z or x, y, z, nx, ny, nz in mm, found {found} cells"
            ),
            Self::NoNormal { index } => {
                write!(f, "the normal of point {index}, from 0, has no length")
            }
            Self::Face { index } => {
                write!(f, "face {index}, from 0, does not name three or more vertices that exist")
            }
            Self::Nothing { what } => write!(f, "the file holds no {what}"),
        }
    }
}
