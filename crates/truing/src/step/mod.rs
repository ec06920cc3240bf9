//! STEP files (ISO 10303-21): the faces of a part, in mm.
//!
//! Of a file of any application protocol that is read which leads from the shapes of a part to the
//! surfaces of their faces and to the unit of length. Boundaries of faces, assemblies, colours and
//! dimensions are not.

mod entity;
mod exchange;
mod face;
mod net;
mod problem;
mod scanner;
mod shown;
mod surface;
mod unit;
mod value;

use std::path::Path;

use crate::Error;
use crate::file::{InputFile, MAX_BYTES, read_bytes};
use exchange::Exchange;

pub use face::StepFace;
pub use net::StepNet;
pub use problem::StepProblem;
pub use surface::StepSurface;

/// Faces of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct StepFaces {
    /// The file.
    pub input: InputFile,
    /// In the order of the file, each in the coordinates of its own part.
    pub faces: Vec<StepFace>,
    /// Whether the file places its parts in an assembly, which is not followed.
    pub is_assembly: bool,
}

/// Reads the faces of the parts in a STEP file.
///
/// # Errors
///
/// [`Error::NotRead`], [`Error::Step`].
pub fn read_step(path: &Path) -> Result<StepFaces, Error> {
    let bytes = read_bytes(path, MAX_BYTES).map_err(|problem| Error::not_read(path, problem))?;
    let fail = |problem| Error::Step { path: path.to_owned(), problem: Box::new(problem) };
    let exchange = Exchange::new(&bytes).map_err(fail)?;
    let faces = exchange.faces().map_err(fail)?;
    let is_assembly = exchange.is_assembly;
    Ok(StepFaces { input: InputFile::given(path, &bytes), faces, is_assembly })
}
