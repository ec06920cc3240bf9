use serde::Serialize;

use crate::{Case, InputFile, Provenance};

/// What every answer says of itself: its form, the program, and what it rests on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Header {
    /// Name of the answer's form, `truing/loop/1`; a form with other keys has another number.
    pub schema: &'static str,
    /// What wrote the answer.
    pub program: Program,
    /// Every file that was read.
    pub inputs: Vec<InputFile>,
    /// Where the data come from, as the case says it.
    pub provenance: Option<Provenance>,
    /// How files were understood that are not written as the format says.
    pub notes: Vec<String>,
}

/// The program that wrote an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Program {
    /// Its name.
    pub name: &'static str,
    /// Its version.
    pub version: &'static str,
}

/// This program.
pub(crate) const PROGRAM: Program =
    Program { name: env!("CARGO_PKG_NAME"), version: env!("CARGO_PKG_VERSION") };

impl Header {
    /// Of an answer about a case.
    pub(crate) fn of(schema: &'static str, case: &Case) -> Self {
        Self {
            provenance: case.provenance.clone(),
            notes: case.notes.clone(),
            ..Self::without_case(schema, case.inputs.clone())
        }
    }

    /// Of an answer about single files, or none.
    pub(crate) fn without_case(schema: &'static str, inputs: Vec<InputFile>) -> Self {
        Self { schema, program: PROGRAM, inputs, provenance: None, notes: Vec::new() }
    }
}
