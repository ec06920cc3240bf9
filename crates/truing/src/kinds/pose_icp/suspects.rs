//! What may be wrong with touches of a part, its drawing or its probe.

use super::measured::PoseCase;
use super::{EDGE, POINTS};
use crate::case::{Files, Table};
use crate::kinds::Fitted;
use crate::kinds::surface::mistakes_of_drawing;
use crate::suspect::{
    Dimension, Hypothesis, Yardstick, cycles, exchanged_rows, exchanges, farthest, lengths,
    other_setting, rows_shifted, signs, spread_of, units,
};

const XYZ: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
/// Misfit over the spread of the points that no part has: 0.3 mm in 100 mm.
const GROSS: f64 = 0.003;
/// The same beyond which part and points have nothing to do with each other.
const UNMATCHED: f64 = 0.05;
/// Rows looked at for exchanged labels.
const FARTHEST: usize = 6;

pub(super) fn mistakes(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    let columns = ["point", XYZ[0], XYZ[1], XYZ[2]];
    let table = files.folder.table(POINTS, &columns).ok();
    let table = table.as_ref();
    let mut all = sides(files);
    all.extend(lengths(&files.document, &["probe", "tip_radius_mm"]));
    all.extend(mistakes_of_drawing(files));
    all.extend(of_points(POINTS, table));
    if files.folder.has(EDGE) {
        let edge = files.folder.table(EDGE, &columns).ok();
        all.extend(of_points(EDGE, edge.as_ref()));
    }
    for column in XYZ {
        all.extend(rows_shifted(POINTS, table, &[column], None));
    }
    if let Some(fitted) = fitted {
        all.extend(exchanged_rows(POINTS, table, &XYZ[2..], &farthest(fitted, FARTHEST)));
    }
    all
}

fn of_points(file: &'static str, table: Option<&Table>) -> Vec<Hypothesis> {
    let mut all = units(file, table, &XYZ, Dimension::Length);
    all.extend(signs(file, table, &XYZ));
    all.extend(exchanges(file, table, &XYZ));
    all.extend(cycles(file, table, XYZ));
    all
}

/// The probe on the other side of the part.
fn sides(files: &Files) -> Vec<Hypothesis> {
    let path = ["probe", "side"];
    let given = files.document.value(&path);
    let other = if given.is_some_and(|side| side.as_str() == Some("-z")) { "+z" } else { "-z" };
    let what = format!("wrong, the probe was on the other side of the part: \"{other}\"");
    vec![other_setting(&path, "input:side", &what, toml::Value::String(other.to_owned()))]
}

pub(super) fn yardstick(case: &PoseCase, _: &Fitted) -> Yardstick {
    let spread = spread_of(case.points.centers_mm.iter().map(|p| p.coords.as_slice()));
    Yardstick { spread, taken_up: 0.0, gross: GROSS, unmatched: UNMATCHED }
}
