//! What may be wrong with the numbers of a drawing, or with touches of the part.

use super::form_map::{DEVIATION, FORM};
use super::grid::HEIGHTS;
use super::nurbs::CONTROL;
use crate::case::{Document, Table};
use crate::kind::Files;
use crate::measured::Fitted;
use crate::suspect::{
    Dimension, Hypothesis, Proof, Twice, Typed, Yardstick, clipped_of_few, coarser_than_others,
    copies, cycles, doubled, exchanged_rows, exchanges, farthest, held, increments, lengths,
    minus_lost, number, of_another_part, other_setting, polar, rows_left_out, scaled_setting,
    signs, silent, spread_of_places, standing_still, units, zeros,
};

pub(crate) const XYZ: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
/// Numbers of the drawing and of the probe that were typed.
pub(crate) const TYPED: [Typed; 9] = [
    Typed { path: &["surface", "conic"], unwritten: Some(0.0) },
    Typed::of(&["surface", "radius_mm"]),
    Typed::of(&["surface", "coefficients"]),
    Typed::of(&["surface", "terms"]),
    Typed::of(&["surface", "center_mm"]),
    Typed::of(&["surface", "point_mm"]),
    Typed::of(&["surface", "normal"]),
    Typed::of(&["surface", "unit_mm"]),
    Typed::of(&["probe", "tip_radius_mm"]),
];
/// Deviation over the spread of the touches that no part has: 0.3 mm in 100 mm.
const GROSS: f64 = 0.003;
/// The same beyond which part and touches have nothing to do with each other.
const UNMATCHED: f64 = 0.05;
/// Rows looked at for exchanged labels.
const FARTHEST: usize = 6;

/// Sign and unit of the vertex radius, the diameter for the radius, the sign of the conic.
pub(crate) fn mistakes_of_drawing(files: &Files) -> Vec<Hypothesis> {
    let document = &files.document;
    let mut all = lengths(document, &["surface", "radius_mm"]);
    let bowl = "of the opposite sign (bowl for dome, inward normal)";
    let radius = ["surface", "radius_mm"];
    all.extend(scaled_setting(document, &radius, "input:sign", bowl, -1.0));
    let conic = ["surface", "conic"];
    all.extend(scaled_setting(document, &conic, "input:sign", "of the opposite sign", -1.0));
    let eccentricity = number(document, &conic).filter(|e| *e > 0.0);
    all.extend(eccentricity.and_then(|e| {
        let what = "the eccentricity, not the conic constant";
        scaled_setting(document, &conic, "input:eccentricity", what, -e)
    }));
    all.extend(lengths(document, &["surface", "unit_mm"]));
    all.extend(unit_of_mesh(document));
    all.extend(terms_turned(document));
    all.extend(poles(document));
    all.extend(mistakes_of_heights(files));
    let what = "taken off already, the coordinates are those of the contact and not of the centre of the ball";
    all.extend(scaled_setting(
        document,
        &["probe", "tip_radius_mm"],
        "input:compensated",
        what,
        0.0,
    ));
    all
}

/// A mesh in another unit than mm, where nothing is said of it.
fn unit_of_mesh(document: &Document) -> Vec<Hypothesis> {
    const UNITS_MM: [(&str, f64); 4] =
        [("inches", 25.4), ("metres", 1e3), ("cm", 10.0), ("µm", 1e-3)];
    let shape = document.value(&["surface", "shape"]);
    let is_mesh = shape.is_some_and(|shape| shape.as_str() == Some("mesh"));
    let path = ["surface", "unit_mm"];
    if !is_mesh || document.value(&path).is_some() {
        return Vec::new();
    }
    let of = |(unit, unit_mm): &(&str, f64)| {
        let what = format!("1 as it is not given, but the mesh is in {unit}: {unit_mm}");
        other_setting(&path, "input:unit", &what, toml::Value::Float(*unit_mm))
    };
    UNITS_MM.iter().map(of).collect()
}

/// Unit, sign and order of the columns of heights that the part was drawn by, or that its form was measured by.
fn mistakes_of_heights(files: &Files) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    for (file, height) in [(FORM, DEVIATION), (HEIGHTS, "z_mm"), (CONTROL, "z_mm")] {
        // A table that no shape uses is not read.
        let Some(table) = files.folder.known(file) else { continue };
        let table = Some(&*table);
        all.extend(units(file, table, &[height], Dimension::Length));
        all.extend(units(file, table, &["x_mm", "y_mm"], Dimension::Length));
        for column in ["x_mm", "y_mm", height] {
            all.extend(signs(file, table, &[column]));
        }
        for pair in [["x_mm", "y_mm"], ["i", "j"]] {
            all.extend(exchanges(file, table, &pair));
        }
    }
    all
}

/// The two coordinates of the terms of a polynomial exchanged.
fn terms_turned(document: &Document) -> Option<Hypothesis> {
    let path = ["surface", "terms"];
    let mut terms = document.value(&path).and_then(|value| value.as_array().cloned())?;
    for term in terms.iter_mut().filter_map(toml::Value::as_array_mut).filter(|t| t.len() > 1) {
        term.swap(0, 1);
    }
    let what = "wrong, the coordinates x and y are exchanged (swapped) in its terms: `[j, i, a]` for `[i, j, a]`";
    Some(other_setting(&path, "input:exchanged", what, toml::Value::Array(terms)))
}

/// A pole of a sphere, or the lowest point of the ball that touched it there, given for its centre.
fn poles(document: &Document) -> Vec<Hypothesis> {
    let path = ["surface", "center_mm"];
    let center = document.value(&path).and_then(|value| value.as_array().cloned());
    let (Some(center), Some(radius)) = (center, number(document, &["surface", "radius_mm"])) else {
        return Vec::new();
    };
    let ball = number(document, &["probe", "tip_radius_mm"]).unwrap_or(0.0);
    let mut all = Vec::new();
    for axis in 0..center.len() {
        for by in [radius, -radius, radius + ball, -radius - ball] {
            let mut other = center.clone();
            let Some(value) = other[axis].as_float() else { continue };
            other[axis] = toml::Value::Float(value + by);
            let what = format!(
                "wrong, its number {} is that of a pole (the top) and not of the centre: {} instead of {value}",
                axis + 1,
                value + by
            );
            all.push(other_setting(&path, "input:pole", &what, toml::Value::Array(other)));
        }
    }
    all
}

/// Units, signs and order of the coordinates of a table of points.
pub(crate) fn mistakes_of_points(file: &'static str, table: Option<&Table>) -> Vec<Hypothesis> {
    let mut all = units(file, table, &XYZ, Dimension::Length);
    all.extend(doubled(file, table, &XYZ, Twice::Diameter));
    all.extend(polar(file, table, &XYZ));
    all.extend(signs(file, table, &XYZ));
    all.extend(increments(file, table, &XYZ, &[]));
    all.extend(copies(file, table, &XYZ, Proof::Gross));
    all.extend(exchanges(file, table, &XYZ));
    all.extend(cycles(file, table, XYZ));
    all
}

/// Rows of a table of points in another order, of another part, or with a slip of the pen; `known` columns
/// of text have a meaning of their own.
pub(crate) fn mistakes_of_rows(
    file: &'static str,
    table: Option<&Table>,
    known: &[&str],
    fitted: Option<&Fitted>,
) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    let without = |_: &Table, rows: &[bool]| vec![rows_left_out(file, rows)];
    all.extend(silent(file, table, &XYZ));
    all.extend(minus_lost(file, table, &XYZ, fitted));
    all.extend(coarser_than_others(file, table, &XYZ));
    all.extend(standing_still(file, table, &XYZ, without));
    all.extend(held(file, table, &XYZ, without));
    all.extend(clipped_of_few(file, table, &XYZ, without));
    all.extend(zeros(file, table, &XYZ, without));
    if let Some(fitted) = fitted {
        all.extend(exchanged_rows(file, table, &XYZ[2..], &farthest(fitted, FARTHEST)));
        all.extend(of_another_part(file, table, known));
    }
    all
}

/// What a deviation of touches at these places is measured by.
pub(crate) fn yardstick_of<'p>(places: impl Iterator<Item = &'p [f64]> + Clone) -> Yardstick {
    let spread = spread_of_places(places);
    Yardstick { spread, taken_up: 0.0, gross: GROSS, unmatched: UNMATCHED, ..Yardstick::NONE }
}
