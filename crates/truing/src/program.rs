use std::path::Path;

use nalgebra::{Affine3, Isometry3, convert};
use pose_icp::{ProgramOptions, correct_program_for_machine};

use crate::file::{MAX_BYTES, read_text};
use crate::found_pose::found_pose;
use crate::header::PROGRAM;
use crate::kinds::{PoseIcpEstimates, plausible_reading};
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
/// A program in coordinates of the workpiece is one planned at the identity. With `answer`, what
/// `truing loop --json` printed for the same touches, the part lies where the loop has it, and the
/// program says what the machine reads there, its long or skew axes included. What is returned
/// carries a comment that says that it was corrected, by which version, and for which case
/// ([`Case::sha256`]); a program with such a comment is refused.
///
/// # Errors
///
/// As [`solve`]; [`Error::NoPose`] for another kind of case, [`Error::NotRead`],
/// [`Error::Carry`] for an answer on other touches, [`Error::Implausible`], [`Error::AlreadyCorrected`], [`Error::Program`] with the line that cannot be corrected.
pub fn correct(
    case: &Case,
    program: &Path,
    planned: &Isometry3<f64>,
    options: &ProgramOptions,
    answer: Option<&Path>,
) -> Result<Corrected, Error> {
    let text =
        read_text(program, MAX_BYTES).map_err(|problem| Error::not_read(program, problem))?;
    if let Some(line) = text.lines().position(is_marked) {
        return Err(Error::AlreadyCorrected { path: program.to_owned(), line: line + 1 });
    }
    let solved = solve(case)?;
    let Some(estimates) = solved.estimates.downcast_ref::<PoseIcpEstimates>() else {
        return Err(Error::NoPose { kind: case.kind });
    };
    let found: Affine3<f64> = match answer {
        Some(answer) => found_pose(answer, estimates)?,
        None => convert(estimates.pose.numbers.machine_from_workpiece()),
    };
    plausible_reading(&found.matrix().fixed_view::<3, 3>(0, 0).into_owned())?;
    let correction = found * convert::<_, Affine3<f64>>(planned.inverse());
    let corrected = correct_program_for_machine(&text, &correction, options)
        .map_err(|source| Error::Program { path: program.to_owned(), source: Box::new(source) })?;
    Ok(Corrected { program: marked(&corrected, &mark(case)), warnings: solved.warnings })
}

/// Words of the mark that no other comment has beside one another.
const MARK: &str = "CORRECTED FOR CASE ";

/// The comment of a corrected program, in capitals as old controls read no others.
fn mark(case: &Case) -> String {
    let (name, version) = (PROGRAM.name, PROGRAM.version);
    format!("({} {version} {MARK}{})", name, case.sha256()).to_uppercase()
}

/// Whether a line holds such a comment, of any version and however a control wrote it back.
fn is_marked(line: &str) -> bool {
    let line = line.to_ascii_uppercase();
    let Some(at) = line.find(MARK) else { return false };
    line[..at].contains(&PROGRAM.name.to_ascii_uppercase())
}

/// The program with `mark` as a line of its own: before the first block, but below what has to be
/// at the top, a tape's `%` and the program's number or name.
fn marked(program: &str, mark: &str) -> String {
    let end = program
        .find('\n')
        .map_or("\n", |at| if program[..at].ends_with('\r') { "\r\n" } else { "\n" });
    let stays_above = |line: &&str| {
        let line = line.trim_start();
        let digits = line.strip_prefix(['O', 'o', ':']).map(str::trim_start);
        line.is_empty()
            || line.starts_with('%')
            || digits.is_some_and(|d| d.starts_with(|c: char| c.is_ascii_digit()))
    };
    let at: usize = program.split_inclusive('\n').take_while(stays_above).map(str::len).sum();
    let (above, below) = program.split_at(at);
    let join = if above.is_empty() || above.ends_with('\n') { "" } else { end };
    format!("{above}{join}{mark}{end}{below}")
}

#[cfg(test)]
mod tests {
    use super::{is_marked, marked};

    #[test]
    fn the_mark_stands_below_what_has_to_be_at_the_top() {
        let mark = "(TRUING 1.2.3 CORRECTED FOR CASE 00)";
        assert_eq!(marked("G0 X1\n", mark), format!("{mark}\nG0 X1\n"));
        assert_eq!(
            marked("%\r\nO0012 (PART)\r\n\r\nG0 X1\r\n%\r\n", mark),
            format!("%\r\nO0012 (PART)\r\n\r\n{mark}\r\nG0 X1\r\n%\r\n")
        );
        assert_eq!(marked("%", mark), format!("%\n{mark}\n"));
        assert_eq!(marked("", mark), format!("{mark}\n"));
    }

    #[test]
    fn marks_are_known_in_any_form() {
        assert!(is_marked("N10 (truing 0.0.9 corrected for case 00ff)"));
        assert!(is_marked("; TRUING 9 CORRECTED FOR CASE AB"));
        assert!(!is_marked("(CORRECTED FOR CASE HARDENING)"));
        assert!(!is_marked("(before truing)"));
    }
}
