//! What may be wrong with touches of a part, its drawing or its probe.

use super::settings::{EDGE, POINTS};
use super::tables::KNOWN;
use crate::case::{Change, Document, Edit, Table};
use crate::kind::Files;
use crate::kinds::surface::{XYZ, mistakes_of_drawing, mistakes_of_points, mistakes_of_rows};
use crate::measured::Fitted;
use crate::suspect::{
    Hypothesis, exchanged_rows, lengths, number, other_setting, rows_shifted, scaled_setting, signs,
};

pub(super) fn mistakes(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    let columns = ["point", XYZ[0], XYZ[1], XYZ[2]];
    let table = files.folder.table(POINTS, &columns).ok();
    let table = table.as_ref();
    let mut all = sides(files);
    all.extend(lengths(&files.document, &["probe", "tip_radius_mm"]));
    all.extend(turned(&files.document));
    all.extend(mistakes_of_drawing(files));
    all.extend(mistakes_of_points(POINTS, table));
    all.extend(turned_with_start(&files.document, table));
    if files.folder.has(EDGE) {
        let edge = files.folder.table(EDGE, &columns).ok();
        all.extend(mistakes_of_points(EDGE, edge.as_ref()));
        all.extend(rows_shifted(EDGE, edge.as_ref(), &XYZ, None));
        let rows: Vec<usize> = (0..edge.as_ref().map_or(0, Table::n_rows)).collect();
        all.extend(exchanged_rows(EDGE, edge.as_ref(), &XYZ, &rows));
        all.push(of_another_place());
    }
    all.extend(mistakes_of_rows(POINTS, table, KNOWN, fitted));
    all
}

/// Side touches that put the part elsewhere than its surface does.
fn of_another_place() -> Hypothesis {
    let description = format!(
        "the side touches of {EDGE} do not fit the surface: one of them is wrong, or they are of another \
         session or part; touch the side again, or leave the file out"
    );
    let edits = vec![Edit { file: EDGE, change: Change::Omit }];
    Hypothesis::of("input:misplaced", (EDGE, &XYZ), description, edits)
}

/// A coordinate of the opposite sign in the touches and in the pose to begin with, which was taken from them.
fn turned_with_start(document: &Document, table: Option<&Table>) -> Vec<Hypothesis> {
    let starts =
        [["pose", "initial", "x_mm"], ["pose", "initial", "y_mm"], ["pose", "initial", "z_mm"]];
    let of = |(column, start): (&str, [&'static str; 3])| {
        let begins = scaled_setting(document, &start, "input:sign", "of the opposite sign", -1.0)?;
        let mut turned = signs(POINTS, table, &[column]).pop()?;
        turned.edits.extend(begins.edits);
        Some(turned)
    };
    XYZ.into_iter().zip(starts).filter_map(of).collect()
}

/// The declared turn of a part that is not of revolution the other way round, in radians, or by a quarter or half turn
/// off.
fn turned(document: &Document) -> Vec<Hypothesis> {
    let gamma = ["pose", "gamma_deg"];
    let deg_per_rad = 180.0 / std::f64::consts::PI;
    let is_turned = number(document, &gamma).is_some_and(|gamma_deg| gamma_deg != 0.0);
    let other = |effect, what, factor| scaled_setting(document, &gamma, effect, what, factor);
    let both = [
        other("input:sign", "of the opposite sign", -1.0),
        other("input:unit", "in another unit, radians", deg_per_rad),
    ];
    let declared = number(document, &gamma).unwrap_or(0.0);
    let turns = [declared + 90.0, declared - 90.0, declared + 180.0, 90.0 - declared];
    let by_turn = turns.map(|to| {
        let what = format!(
            "wrong, the part was clamped a quarter or half turn round, or the angle was taken from another axis: {to} \
             instead of {declared}"
        );
        other_setting(&gamma, "input:rotation", &what, toml::Value::Float(to))
    });
    both.into_iter().flatten().filter(|_| is_turned).chain(by_turn).collect()
}

/// The probe on the other side of the part.
fn sides(files: &Files) -> Vec<Hypothesis> {
    let path = ["probe", "side"];
    let given = files.document.value(&path);
    let other = if given.is_some_and(|side| side.as_str() == Some("-z")) { "+z" } else { "-z" };
    let what = format!("wrong, the probe was on the other side of the part: \"{other}\"");
    vec![other_setting(&path, "input:side", &what, toml::Value::String(other.to_owned()))]
}
