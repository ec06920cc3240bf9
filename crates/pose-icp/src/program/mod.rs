//! The pose as a correction of the program that was written for the planned one.

mod block;
mod correct;
mod error;
mod modal;

pub use correct::{
    ProgramOptions, ProgramPoint, correct_points, correct_program, correct_program_for_machine,
    machine_correction, program_points,
};
pub use error::{ProgramError, Refused};
