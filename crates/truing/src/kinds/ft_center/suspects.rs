//! What may be wrong with presses, displacements or static poses.

use std::collections::BTreeSet;

use ft_center::{Displacement, Press, PressRole, StaticPose};

use super::copied_records::copied_records;
use super::gravity_estimates::GravityEstimates;
use super::settings::{DISPLACEMENTS, GRAVITY, PRESSES, WRENCH};
use crate::case::{Edit, Table};
use crate::kind::Files;
use crate::kinds::orientation::{QUATERNION, mistakes_of_quaternion};
use crate::kinds::positioning::mistakes_of_axis;
use crate::measured::Fitted;
use crate::suspect::{
    Dimension, Hypothesis, Proof, Twice, Yardstick, channels, copies, cycles, doubled,
    exchanged_rows, exchanges, farthest, increments, lengths, numbers, other_setting, points_lost,
    polar, rows_left_out, rows_shifted, scaled_setting, signs, sorted_as_text, spread_of,
    standing_still, units, units_from_a_row,
};

pub(super) const FORCES: [&str; 3] = ["fx_n", "fy_n", "fz_n"];
pub(super) const MOMENTS: [&str; 3] = ["mx_nmm", "my_nmm", "mz_nmm"];
pub(super) const MACHINE: [&str; 2] = ["machine_x_mm", "machine_y_mm"];
/// Misfit over the spread of the positions that no head makes: 3 mm of 30 mm.
const GROSS: f64 = 0.1;
/// The same beyond which wrenches and positions have nothing to do with each other.
const UNMATCHED: f64 = 0.4;
/// Misfit of a displacement over its size that no machine makes.
const GROSS_TRAVEL: f64 = 0.02;
/// Misfit of a wrench over what gravity changes in it that no sensor makes.
const GROSS_WRENCH: f64 = 0.1;
/// The same of forces and moments together where poses and wrenches have nothing to do with each other:
/// each alone is then nearly all that is read.
const UNMATCHED_WRENCH: f64 = 1.2;
/// Rows looked at for exchanged labels.
const FARTHEST: usize = 6;
/// Cosine from which on two directions are one, but for a tilt.
const SAME_LINE: f64 = 0.9;

pub(super) fn mistakes(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    if files.folder.has(DISPLACEMENTS) {
        mistakes_of_axis(DISPLACEMENTS, files, fitted)
    } else if files.folder.has(GRAVITY) {
        gravity(files, fitted)
    } else {
        presses(files, fitted)
    }
}

fn presses(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    let folder = &files.folder;
    let (Ok(wrench), Ok(known)) = (folder.table(WRENCH, &FORCES), folder.table(PRESSES, &MACHINE))
    else {
        return Vec::new();
    };
    let without = |wrench: &Table, rows: &[bool]| presses_left_out(wrench, &known, rows);
    let six = [FORCES, MOMENTS].concat();
    let mut all = channels(WRENCH, Some(&wrench), &six, without);
    all.extend(copied_records(&wrench, &six, |rows| without(&wrench, rows)));
    let (wrench, known) = (Some(&wrench), Some(&known));
    all.extend(copies(WRENCH, wrench, &FORCES, Proof::Data));
    all.extend(copies(WRENCH, wrench, &MOMENTS, Proof::Data));
    all.extend(units(WRENCH, wrench, &FORCES, Dimension::Force));
    all.extend(units(WRENCH, wrench, &MOMENTS, Dimension::Moment));
    all.extend(units(PRESSES, known, &MACHINE, Dimension::Length));
    all.extend(units_from_a_row(PRESSES, known, &MACHINE, Dimension::Length));
    all.extend(points_lost(PRESSES, known, &MACHINE));
    all.extend(doubled(PRESSES, known, &MACHINE, Twice::Diameter));
    all.extend(polar(PRESSES, known, &MACHINE));
    all.extend(increments(PRESSES, known, &MACHINE, &[]));
    all.extend(of_wrench(WRENCH, wrench));
    all.extend(lengths(&files.document, &["contact", "z0_mm"]));
    let other_side = "of the opposite sign, on the wrong side of the sensor's reference point";
    let z0 = ["contact", "z0_mm"];
    all.extend(scaled_setting(&files.document, &z0, "input:side", other_side, -1.0));
    all.extend(copies(PRESSES, known, &MACHINE, Proof::Gross));
    all.extend(exchanges(PRESSES, known, &MACHINE));
    all.extend(signs(PRESSES, known, &MACHINE));
    all.extend(handedness(files));
    all.extend(sorted_as_text(PRESSES, known, "press", &MACHINE));
    if let (Some(fitted), Some(table)) = (fitted, known) {
        let is_known = |row: &usize| {
            table.column("use").is_some_and(|column| table.cell(*row, column) != "locate")
        };
        let rows: Vec<usize> = (0..table.n_rows()).filter(is_known).collect();
        let far: Vec<usize> =
            farthest(fitted, FARTHEST).into_iter().filter_map(|o| rows.get(o).copied()).collect();
        all.extend(exchanged_rows(PRESSES, known, &MACHINE, &far));
    }
    all
}

/// Sensor and machine turned against each other, or not, otherwise than is declared.
fn handedness(files: &Files) -> Option<Hypothesis> {
    let path = ["model", "handedness"];
    let other = match files.document.value(&path)?.as_str()? {
        "same" => "opposed",
        "opposed" => "same",
        _ => return None,
    };
    let what = format!("wrong, machine and sensor are mirrored otherwise: \"{other}\"");
    Some(other_setting(&path, "input:handedness", &what, toml::Value::String(other.to_owned())))
}

/// What may be wrong with the six columns of a wrench.
fn of_wrench(file: &'static str, table: Option<&Table>) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    for family in [MOMENTS, FORCES] {
        all.extend(points_lost(file, table, &family));
        all.extend(exchanges(file, table, &family));
        all.extend(cycles(file, table, family));
        all.extend(signs(file, table, &family));
    }
    all
}

/// Every press of which a sample is marked goes, with all of its samples.
fn presses_left_out(wrench: &Table, known: &Table, rows: &[bool]) -> Vec<Edit> {
    let (Some(of), Some(name)) = (wrench.column("press"), known.column("press")) else {
        return Vec::new();
    };
    let clipped: BTreeSet<&str> =
        (0..wrench.n_rows()).filter(|&row| rows[row]).map(|row| wrench.cell(row, of)).collect();
    let marked = |table: &Table, column: usize| -> Vec<bool> {
        (0..table.n_rows()).map(|row| clipped.contains(table.cell(row, column))).collect()
    };
    vec![rows_left_out(WRENCH, &marked(wrench, of)), rows_left_out(PRESSES, &marked(known, name))]
}

fn gravity(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    let Ok(table) = files.folder.table(GRAVITY, &QUATERNION) else { return Vec::new() };
    let wrench = [FORCES, MOMENTS].concat();
    let table = Some(&table);
    let mut all = Vec::new();
    all.extend(units(GRAVITY, table, &FORCES, Dimension::Force));
    all.extend(units(GRAVITY, table, &MOMENTS, Dimension::Moment));
    let without = |_: &Table, rows: &[bool]| vec![rows_left_out(GRAVITY, rows)];
    all.extend(standing_still(GRAVITY, table, &wrench, without));
    all.extend(copies(GRAVITY, table, &FORCES, Proof::Data));
    all.extend(copies(GRAVITY, table, &MOMENTS, Proof::Data));
    all.extend(of_wrench(GRAVITY, table));
    all.extend(mistakes_of_quaternion(GRAVITY, table));
    all.extend(exchanges(GRAVITY, table, &QUATERNION));
    all.extend(gravity_elsewhere(files));
    all.extend(rows_shifted(GRAVITY, table, &wrench, None));
    if let Some(fitted) = fitted {
        all.extend(exchanged_rows(GRAVITY, table, &wrench, &farthest(fitted, FARTHEST)));
    }
    all
}

/// The direction of gravity reversed, or along another axis of the base.
fn gravity_elsewhere(files: &Files) -> Vec<Hypothesis> {
    let path = ["model", "gravity"];
    let declared = match files.document.value(&path) {
        None => Some(vec![0.0, 0.0, -1.0]),
        Some(_) => numbers(&files.document, &path).filter(|declared| declared.len() == 3),
    };
    let Some(declared) = declared else { return Vec::new() };
    let another = |what: &str, direction: [f64; 3]| {
        let value = direction.map(toml::Value::Float).to_vec();
        other_setting(&path, "input:direction", what, toml::Value::Array(value))
    };
    let reversed = [-declared[0], -declared[1], -declared[2]];
    let mut all =
        vec![another("reversed (opposite direction): it points down in the base", reversed)];
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        for (sign, said) in [(1.0, ""), (-1.0, "−")] {
            let mut direction = [0.0; 3];
            direction[axis] = sign;
            let along: f64 = declared.iter().zip(direction).map(|(a, b)| a * b).sum();
            let length = declared.iter().map(|v| v * v).sum::<f64>().sqrt();
            // Along the same line it is the one above, or no change.
            if along.abs() < SAME_LINE * length {
                let what = format!(
                    "along another axis of the base: gravity points along {said}{name} there"
                );
                all.push(another(&what, direction));
            }
        }
    }
    all
}

pub(super) fn press_yardstick(presses: &[Press]) -> Yardstick {
    let places: Vec<[f64; 2]> = (presses.iter())
        .filter(|p| p.role != PressRole::Locate)
        .map(|p| [p.machine_mm.x, p.machine_mm.y])
        .collect();
    let spread = spread_of(places.iter().map(<[f64; 2]>::as_slice));
    Yardstick { spread, taken_up: 0.0, gross: GROSS, unmatched: UNMATCHED, ..Yardstick::NONE }
}

pub(super) fn displacement_yardstick(rows: &[Displacement]) -> Yardstick {
    let side = |value: fn(&Displacement) -> f64| {
        let points: Vec<[f64; 1]> = rows.iter().map(|row| [value(row)]).collect();
        spread_of(points.iter().map(<[f64; 1]>::as_slice))
    };
    let spread = side(|row| row.commanded_mm).max(side(|row| row.solved_mm));
    Yardstick {
        spread,
        taken_up: 0.0,
        gross: GROSS_TRAVEL,
        unmatched: UNMATCHED,
        ..Yardstick::NONE
    }
}

pub(super) fn gravity_yardstick(poses: &[StaticPose], fitted: &Fitted) -> Yardstick {
    let part = |moments: bool| -> Vec<[f64; 3]> {
        let of = |p: &StaticPose| {
            if moments { p.wrench.torque_nmm } else { p.wrench.force_n }
        };
        poses.iter().map(|p| of(p).into()).collect()
    };
    let spread = |points: Vec<[f64; 3]>| spread_of(points.iter().map(<[f64; 3]>::as_slice));
    let (forces, moments) = (spread(part(false)), spread(part(true)));
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let n = fitted.observations.len().max(1) as f64;
    let square =
        |o: &crate::measured::Observation| o.residual.iter().skip(3).map(|r| r * r).sum::<f64>();
    let missed = (fitted.observations.iter().map(square).sum::<f64>() / n).sqrt();
    let found = fitted.estimates.downcast_ref::<GravityEstimates>();
    let is_upside_down = found.is_some_and(|found| found.weight_n < 0.0);
    let taken_up = forces * (missed / moments).hypot(if is_upside_down { 1.0 } else { 0.0 });
    // Beside a light tool, a zero that turns or a mount that leans may be all that is read: physics is
    // asked before the poses are said not to belong to the wrenches.
    let unmatched = UNMATCHED_WRENCH;
    Yardstick { spread: forces, taken_up, gross: GROSS_WRENCH, unmatched, ..Yardstick::NONE }
}
