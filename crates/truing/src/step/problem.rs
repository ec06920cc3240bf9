use geometry::GeometryError;

use crate::case::quote;

/// Why no surface can be had from a STEP file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StepProblem {
    /// Another kind of file.
    #[error("expected a STEP file, which begins with `ISO-10303-21;`")]
    NotStep,
    /// The end of the file comes too early.
    #[error(
        "line {line}: the file ends in or behind what begins here; it was cut off, export or copy it \
         again"
    )]
    Truncated {
        /// Where that begins, from 1.
        line: usize,
    },
    /// Not as Part 21 of the standard has it.
    #[error("line {line}: expected {expected}, found {}; export the file again", quote(found))]
    Syntax {
        /// From 1.
        line: usize,
        /// What has to be there.
        expected: &'static str,
        /// What is there.
        found: String,
    },
    /// Lists within lists within lists.
    #[error("line {line}: lists are nested deeper than any surface needs; export the file again")]
    TooDeep {
        /// From 1.
        line: usize,
    },
    /// Two entities of one number.
    #[error("line {line}: #{id} is already on line {first_line}; export the file again")]
    Twice {
        /// Number of the entity.
        id: u64,
        /// Of the second, from 1.
        line: usize,
        /// Of the first, from 1.
        first_line: usize,
    },
    /// A reference to nothing.
    #[error(
        "line {line}: #{by} refers to #{id}, which is not in the file; it was cut or edited, \
         export it again"
    )]
    Missing {
        /// From 1.
        line: usize,
        /// Number of the entity that refers.
        by: u64,
        /// Number that it refers to.
        id: u64,
    },
    /// An attribute that is not what the standard has in its place.
    #[error(
        "line {line}: #{id}: attribute {attribute} of {} has to be {expected}; export the file again",
        quote(keyword)
    )]
    Attribute {
        /// From 1.
        line: usize,
        /// Number of the entity.
        id: u64,
        /// Type of the entity.
        keyword: String,
        /// From 1.
        attribute: usize,
        /// What has to be there.
        expected: &'static str,
    },
    /// Knots and control points of a B-spline that do not belong together.
    #[error(
        "line {line}: #{id}: {points} control points of degree {degree} need {} knots along \
         {direction}, with their multiplicities {got} are given; export the face again",
        points.saturating_add(*degree).saturating_add(1)
    )]
    Knots {
        /// From 1.
        line: usize,
        /// Number of the entity.
        id: u64,
        /// u or v.
        direction: &'static str,
        /// Degree.
        degree: usize,
        /// Control points.
        points: usize,
        /// Knots given.
        got: usize,
    },
    /// A direction of length zero, or two that are one.
    #[error("line {line}: #{id} gives no direction in space; export the file again")]
    NoDirection {
        /// From 1.
        line: usize,
        /// Number of the entity.
        id: u64,
    },
    /// Lengths in no known unit.
    #[error(
        "line {line}: #{id} says no unit of length that is known; export the part in millimetres \
         or inches"
    )]
    NoUnit {
        /// From 1.
        line: usize,
        /// Number of the entity.
        id: u64,
    },
    /// Neither solids nor surfaces.
    #[error(
        "the file holds no faces of a solid or of surfaces (ADVANCED_FACE); export the part as a \
         solid, not as a wireframe or as triangles, or export a mesh (.stl, .ply, .obj)"
    )]
    NoFaces,
    /// A face that is not there.
    #[error("there is no face {asked}; the file has {n_faces}, numbered from 1")]
    NoSuchFace {
        /// The number asked for.
        asked: usize,
        /// Faces.
        n_faces: usize,
    },
    /// Several faces, of which none was chosen.
    #[error("the file has {n_faces} faces; say which by --face N; without --out they are listed")]
    WhichFace {
        /// Faces.
        n_faces: usize,
    },
    /// A face of a shape that no case takes.
    #[error(
        "line {line}: face {number} is a {words}, which no case takes; convert it to a B-spline \
         (NURBS) where it was drawn, or export a mesh"
    )]
    NoShape {
        /// Of the face in the file, from 1.
        line: usize,
        /// Number of the face.
        number: usize,
        /// What it is.
        words: String,
    },
    /// A B-spline that is no surface.
    #[error("line {line}: #{id}: {source}")]
    Surface {
        /// From 1.
        line: usize,
        /// Number of the entity.
        id: u64,
        /// Why.
        source: GeometryError,
    },
}
