//! What may be wrong with the touches of a probe, its ball or the drawing of the part.

use super::settings::{MICRO, TOUCHES};
use super::tables::KNOWN;
use crate::case::Table;
use crate::kind::Files;
use crate::kinds::surface::{XYZ, mistakes_of_drawing, mistakes_of_points, mistakes_of_rows};
use crate::measured::Fitted;
use crate::suspect::{Hypothesis, exchanges, lengths, other_setting, rows_shifted, signs};

const APPROACH: [&str; 3] = ["nx", "ny", "nz"];

pub(super) fn mistakes(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    let columns = ["touch", XYZ[0], XYZ[1], XYZ[2]];
    let table = files.folder.table(TOUCHES, &columns).ok();
    let table = table.as_ref();
    let mut all = sides(files);
    all.extend(lengths(&files.document, &["probe", "tip_radius_mm"]));
    all.extend(mistakes_of_drawing(files));
    all.extend(mistakes_of_points(TOUCHES, table));
    if files.folder.has(MICRO) {
        let around = files.folder.table(MICRO, &columns).ok();
        all.extend(mistakes_of_points(MICRO, around.as_ref()));
    }
    all.extend(outward(table));
    all.extend(exchanges(TOUCHES, table, &APPROACH));
    all.extend(signs(TOUCHES, table, &APPROACH));
    all.extend(rows_shifted(TOUCHES, table, &APPROACH, None));
    all.extend(mistakes_of_rows(TOUCHES, table, KNOWN, fitted));
    all
}

/// Directions given as normals of the part instead of approaches, or inward for outward.
fn outward(table: Option<&Table>) -> Vec<Hypothesis> {
    let turned = signs(TOUCHES, table, &APPROACH).pop();
    let named = |found: Hypothesis| Hypothesis {
        effect: "input:normal",
        description: format!(
            "{}; they are normals of the other side, inward instead of outward or outward instead \
             of the approach",
            found.description
        ),
        ..found
    };
    turned
        .filter(|_| table.is_some_and(|t| t.column(APPROACH[0]).is_some()))
        .map(named)
        .into_iter()
        .collect()
}

/// The ball on the other side of the surface.
fn sides(files: &Files) -> Vec<Hypothesis> {
    let of_sphere = files.document.value(&["surface", "shape"]);
    let is_sphere = of_sphere.is_some_and(|shape| shape.as_str() == Some("sphere"));
    let (path, names) = if is_sphere {
        (["surface", "side"], ["outside", "inside"])
    } else {
        (["probe", "side"], ["+z", "-z"])
    };
    let given = files.document.value(&path);
    let is_second = given.is_some_and(|side| side.as_str() == Some(names[1]));
    // Where nothing is given, either side may be the one that was taken.
    let others = if is_second { &names[..1] } else { &names[1..] };
    let one = |other: &&str| {
        let what = format!("wrong, the ball was on the other side of the surface: \"{other}\"");
        other_setting(&path, "input:side", &what, toml::Value::String((*other).to_owned()))
    };
    others.iter().map(one).collect()
}
