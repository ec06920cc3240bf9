use std::path::Path;

use nalgebra::Isometry3;
use pose_icp::{ProgramOptions, correct_program};

use crate::estimates::Estimates;
use crate::solved::solve;
use crate::{Case, Error};

/// A program corrected for where the part lies.
#[derive(Clone, Debug, PartialEq)]
pub struct Corrected {
    /// Text of the program.
    pub program: String,
    /// Notes the user should read.
    pub warnings: Vec<String>,
}

/// Solves a `pose-icp` case and moves a G-code program, written for the part at `planned`
/// (workpiece to machine), to where the part is.
///
/// A program in coordinates of the workpiece is one planned at the identity.
///
/// # Errors
///
/// As [`solve`]; [`Error::NoPose`] for another kind of case, [`Error::NotRead`],
/// [`Error::Program`] with the line that cannot be corrected.
pub fn correct(
    case: &Case,
    program: &Path,
    planned: &Isometry3<f64>,
    options: &ProgramOptions,
) -> Result<Corrected, Error> {
    let solved = solve(case)?;
    let Estimates::PoseIcp(estimates) = &solved.estimates else {
        return Err(Error::NoPose { kind: case.kind });
    };
    let path = || program.to_owned();
    let text = std::fs::read_to_string(program)
        .map_err(|e| Error::NotRead { path: path(), reason: e.kind() })?;
    let correction = estimates.pose.machine_from_workpiece() * planned.inverse();
    let program = correct_program(&text, &correction, options)
        .map_err(|source| Error::Program { path: path(), source: Box::new(source) })?;
    Ok(Corrected { program, warnings: solved.warnings })
}
