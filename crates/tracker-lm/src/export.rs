//! The six errors as tables that other programs read.

use std::fmt::Write as _;

use nalgebra::Vector6;

use crate::{AxisError, AxisLetter};

/// Triplets that LinuxCNC reads at most.
const LINUXCNC_MOST: usize = 256;

/// CSV with ISO 230 names: `angle_deg, EXB_mm … ECB_rad, std_EXB_mm … std_ECB_rad`, ascending.
#[must_use]
pub fn axis_errors_csv(letter: AxisLetter, errors: &[AxisError]) -> String {
    let names = letter.error_names();
    let unit = |c: usize| if c < 3 { "mm" } else { "rad" };
    let mut text = String::from("angle_deg");
    for prefix in ["", "std_"] {
        for (c, name) in names.iter().enumerate() {
            let _ = write!(text, ",{prefix}{name}_{}", unit(c));
        }
    }
    text.push('\n');
    for error in ascending(errors) {
        let _ = write!(text, "{}", error.angle_rad.to_degrees());
        for value in error.error.iter().chain(error.sigmas().iter()) {
            let _ = write!(text, ",{value:.9e}");
        }
        text.push('\n');
    }
    text
}

/// Compensation file for LinuxCNC: triplets «nominal forward reverse» in degrees, ascending.
///
/// For `COMP_FILE_TYPE = 0`: where the axis is when it was sent to `nominal`, coming with rising
/// and with falling angles; that is the error of rotation about its own axis, of which the
/// controller can correct no other. `reversal` is the difference between the two ways, forward
/// minus reverse, of all six errors (zeros where none is known). Of more than 256 angles every
/// so-manieth is kept, and the last: the controller reads no more.
#[must_use]
pub fn linuxcnc_compensation(
    letter: AxisLetter,
    errors: &[AxisError],
    reversal: &Vector6<f64>,
) -> String {
    let own = 3 + letter.own();
    let sorted = ascending(errors);
    let stride = sorted.len().div_ceil(LINUXCNC_MOST - 1).max(1);
    let last = sorted.len().saturating_sub(1);
    let kept = sorted.iter().enumerate().filter(|(i, _)| i % stride == 0 || *i == last);
    let mut text = String::new();
    for (_, error) in kept {
        let at = error.angle_rad.to_degrees();
        let half = 0.5 * reversal[own];
        let [forward, reverse] =
            [half, -half].map(|way| at + (error.error[own] + way).to_degrees());
        let _ = writeln!(text, "{at:.9} {forward:.9} {reverse:.9}");
    }
    text
}

/// First line of the table: nobody shall take it for what a control compensates by.
const NO_COMPENSATION: &str =
    "; Six errors of a rotary axis, to be read: no control takes this file for a compensation";

/// A plain table in the layout of Heidenhain's free tables: `NR`, the angle, and `EXB … ECB`.
///
/// It is for people and for programs of their own. The controls keep compensations in formats that
/// are not published, and none of them imports this. Displacements are in mm, rotations in degrees.
#[must_use]
pub fn heidenhain_table(letter: AxisLetter, errors: &[AxisError]) -> String {
    let mut text = format!("{NO_COMPENSATION}\nBEGIN ERRORS_{}.TAB MM\n", letter.letter());
    let _ = write!(text, "{:<5}{:>14}", "NR", letter.letter());
    for name in letter.error_names() {
        let _ = write!(text, "{name:>14}");
    }
    text.push('\n');
    for (n, error) in ascending(errors).into_iter().enumerate() {
        let _ = write!(text, "{n:<5}{:>+14.6}", error.angle_rad.to_degrees());
        for (c, value) in error.error.iter().enumerate() {
            let value = if c < 3 { *value } else { value.to_degrees() };
            let _ = write!(text, "{value:>+14.6}");
        }
        text.push('\n');
    }
    text.push_str("[END]\n");
    text
}

fn ascending(errors: &[AxisError]) -> Vec<&AxisError> {
    let mut sorted: Vec<_> = errors.iter().collect();
    sorted.sort_by(|a, b| a.angle_rad.total_cmp(&b.angle_rad));
    sorted
}
