//! A matrix and the corrections of the points.

use serde_json::Value;

use crate::handback::Left;
use crate::handback::folder::{Folder, Table};
use crate::handback::loops::{accepted, amplitude, begun, close, numbers, settled, step};
use crate::kinds::frame_fit::frame_scenes::{EFFECTS, scenes};

/// Digits that two ways to a correction may differ by, over the size of the field: sums of a few
/// dozen terms of coordinates.
const FIELD: f64 = 1e-12;

#[test]
fn a_matrix_as_printed_leaves_the_error_that_is_printed() {
    for folder in Folder::committed("frame-fit").into_iter().filter(|f| f.has("pairs.csv")) {
        let json = close(&folder);
        // What is wrong in the input is for the user to put right: the error after is that of the
        // input put right, which this table is not.
        if json["verdict"] != "input-wrong" {
            applied(&folder, &json).assert_is(&folder.name(), &json);
        }
    }
}

#[test]
fn every_effect_of_the_catalogue_is_in_the_matrix_or_in_the_corrections() {
    let mut missing: Vec<&str> = EFFECTS.to_vec();
    for (name, files) in scenes() {
        let folder = Folder::written(&format!("frame-fit/{name}"), &files);
        let json = close(&folder);
        applied(&folder, &json).assert_is(&folder.name(), &json);
        assert_corrections(&folder, &json);
        let found = accepted(&json);
        // A mirrored frame is a mistake in the input before it is an effect.
        let is_named = |effect: &str| {
            let mistake = if effect == "reflection" { "input:sign" } else { effect };
            found.iter().any(|f| f.starts_with(effect) || f.starts_with(mistake))
        };
        missing.retain(|effect| !is_named(effect));
    }
    assert!(missing.is_empty(), "never accepted: {missing:?}");
}

fn axes(table: &Table) -> Vec<&'static str> {
    let all = ["x", "y", "z"];
    all.into_iter().filter(|axis| table.has(&format!("from_{axis}_mm"))).collect()
}

fn points(table: &Table, side: &str) -> Vec<Vec<f64>> {
    let columns: Vec<Vec<f64>> =
        axes(table).iter().map(|axis| table.numbers(&format!("{side}_{axis}_mm"))).collect();
    (0..table.rows()).map(|row| columns.iter().map(|c| c[row]).collect()).collect()
}

fn matrix(json: &Value) -> Vec<Vec<f64>> {
    let rows = json["estimates"]["matrix"].as_array().expect("a matrix");
    rows.iter().map(numbers).collect()
}

/// `to − (matrix · from + correction)` of every point.
fn applied(folder: &Folder, json: &Value) -> Left {
    let table = folder.table("pairs.csv");
    let (mut from, mut to) = (points(&table, "from"), points(&table, "to"));
    // What is handed back for a table with a wrong sign is of the table as corrected.
    for (k, axis) in axes(&table).iter().enumerate() {
        for (side, points) in [("from", &mut from), ("to", &mut to)] {
            let subject = format!("pairs.csv: {side}_{axis}_mm");
            if step(json, "input:sign", Some(&subject)).is_some() {
                for point in points.iter_mut() {
                    point[k] = -point[k];
                }
            }
        }
    }
    let matrix = matrix(json);
    let printed = json["estimates"]["points"].as_array().expect("points");
    let mut left = Left::default();
    for (row, point) in printed.iter().enumerate() {
        let residual: Vec<f64> = (axes(&table).iter().enumerate())
            .map(|(k, axis)| {
                let correction =
                    point[format!("correction_{axis}_mm")].as_f64().expect("a correction");
                to[row][k] - image(&matrix, &from[row])[k] - correction
            })
            .collect();
        left.scale = to[row].iter().chain(&from[row]).fold(left.scale, |m, v| m.max(v.abs()));
        if point["use"] == "fit" {
            left.fitted.push(residual);
        } else {
            left.checked.push(residual);
        }
    }
    left
}

fn image(matrix: &[Vec<f64>], point: &[f64]) -> Vec<f64> {
    let n = point.len();
    (0..n).map(|i| (0..n).map(|k| matrix[i][k] * point[k]).sum::<f64>() + matrix[i][n]).collect()
}

/// Asserts that the corrections printed are those of the effects printed, by the formulas of
/// `docs/frame-fit.md`. Empirical corrections have no formula to use elsewhere.
fn assert_corrections(folder: &Folder, json: &Value) {
    if accepted(json).iter().any(|effect| effect.starts_with("covariate:")) {
        return;
    }
    let table = folder.table("pairs.csv");
    let from = points(&table, "from");
    let uses: Vec<bool> = (0..table.rows())
        .map(|row| !table.has("use") || table.texts("use")[row] != "check")
        .collect();
    let n = from[0].len();
    let fitted: Vec<&Vec<f64>> =
        from.iter().zip(&uses).filter(|(_, fit)| **fit).map(|(p, _)| p).collect();
    let centroid = mean(&fitted);
    let undeformed = times(&linear(&matrix(json), n), &inverse(&strained(json, n)));
    let printed = json["estimates"]["points"].as_array().expect("points");
    for (row, point) in printed.iter().enumerate() {
        let field = field(json, &table, row, &centroid, &fitted, &uses);
        let carried =
            (0..n).map(|i| (0..n).map(|k| undeformed[i][k] * field.source[k]).sum::<f64>());
        let size: f64 = from[row].iter().chain(&[1e3]).fold(0.0, |m: f64, v| m.max(v.abs()));
        for (k, carried) in carried.enumerate() {
            let expected = carried + field.target[k];
            let axis = ["x", "y", "z"][k];
            let found = point[format!("correction_{axis}_mm")].as_f64().expect("a correction");
            assert!(
                (expected - found).abs() < FIELD * size,
                "{}: point {row}, {axis}: {expected:e} by the formulas, {found:e} printed",
                folder.name()
            );
        }
    }
}

/// What effects that are not in the matrix add to a point: in the first frame, before the matrix,
/// and in the second.
struct Field {
    source: Vec<f64>,
    target: Vec<f64>,
}

fn field(
    json: &Value,
    table: &Table,
    row: usize,
    centroid: &[f64],
    fitted: &[&Vec<f64>],
    uses: &[bool],
) -> Field {
    let p = &points(table, "from")[row];
    let n = p.len();
    let u: Vec<f64> = p.iter().zip(centroid).map(|(a, b)| a - b).collect();
    let mut field = Field { source: vec![0.0; n], target: vec![0.0; n] };
    let axis_names = &["x", "y", "z"][..n];
    if let Some(drift) = step(json, "drift", None) {
        for (k, axis) in axis_names.iter().enumerate() {
            field.target[k] += amplitude(drift, axis) * elapsed(table, row);
        }
    }
    if let Some(drift) = step(json, "drift", Some("settling")) {
        let course = settled(drift, elapsed(table, row), table.has("time_s"), table.rows());
        for (k, axis) in axis_names.iter().enumerate() {
            field.target[k] += amplitude(drift, axis) * course;
        }
    }
    for shift in begun(json, ("session-shift", ""), table.texts("point"), row) {
        for (k, axis) in axis_names.iter().enumerate() {
            field.target[k] += amplitude(shift, axis);
        }
    }
    if let Some(sag) = step(json, "sag", None) {
        let mut depth = amplitude(sag, "xx") * 1e-9 * u[0] * u[0]
            + amplitude(sag, "slope x") * 1e-6 * u[0]
            + amplitude(sag, "level");
        if n == 3 {
            depth += amplitude(sag, "xy") * 1e-9 * u[0] * u[1]
                + amplitude(sag, "yy") * 1e-9 * u[1] * u[1]
                + amplitude(sag, "slope y") * 1e-6 * u[1];
        }
        field.source[n - 1] -= depth;
    }
    for column in table.ending("_c") {
        let several = table.ending("_c").len() > 1;
        let subject = several.then_some(column.as_str());
        if let Some(growth) = step(json, "temperature", subject) {
            let excess_k = table.numbers(&column)[row] - 20.0;
            let expansion = amplitude(growth, "expansion") * 1e-6;
            for (k, axis) in axis_names.iter().enumerate() {
                let shift = amplitude(growth, &format!("shift {axis}")) * 1e-3;
                field.source[k] += (expansion * p[k] + shift) * excess_k;
            }
        }
    }
    if let Some(lens) = step(json, "lens-distortion", None) {
        let square: f64 = u.iter().map(|v| v * v).sum();
        let (k1, p1, p2) = (
            amplitude(lens, "k1") * 1e-6,
            amplitude(lens, "p1") * 1e-3,
            amplitude(lens, "p2") * 1e-3,
        );
        field.source[0] +=
            k1 * u[0] * square + p1 * (square + 2.0 * u[0] * u[0]) + p2 * 2.0 * u[0] * u[1];
        field.source[1] +=
            k1 * u[1] * square + p1 * 2.0 * u[0] * u[1] + p2 * (square + 2.0 * u[1] * u[1]);
    }
    if let Some(tilt) = step(json, "perspective", None) {
        let along = (amplitude(tilt, "x") * u[0] + amplitude(tilt, "y") * u[1]) * 1e-3;
        field.source.iter_mut().zip(&u).for_each(|(source, u)| *source += u * along);
    }
    let reach = (fitted.iter().map(|q| distance2(q, centroid)).sum::<f64>()
        / crate::handback::as_f64(fitted.len()))
    .sqrt();
    for degree in [3, 5] {
        let subject = format!("degree {degree}");
        if let Some(bent) = step(json, "polynomial-distortion", Some(&subject)) {
            for (k, component) in ["x", "y"].iter().enumerate() {
                for parameter in bent["parameters"].as_array().expect("parameters") {
                    let name = parameter["name"].as_str().expect("a name");
                    if let Some(monomial) = name.strip_prefix(&format!("{component} ")) {
                        let value = parameter["value"].as_f64().expect("a number");
                        field.source[k] += value * power(monomial, u[0] / reach, u[1] / reach);
                    }
                }
            }
        }
    }
    if let Some(moved) = step(json, "sub-assembly", None) {
        add_body(&mut field.source, moved, table, row, uses);
    }
    let name = &table.texts("point")[row];
    if uses[row]
        && let Some(bad) = step(json, "bad-point", Some(name))
    {
        for (k, axis) in axis_names.iter().enumerate() {
            field.target[k] += amplitude(bad, axis);
        }
    }
    field
}

/// Hours since the first point, or the share of the series that has passed.
fn elapsed(table: &Table, row: usize) -> f64 {
    if table.has("time_s") {
        let time_s = table.numbers("time_s");
        (time_s[row] - time_s[0]) / 3600.0
    } else {
        crate::handback::as_f64(row) / crate::handback::as_f64(table.rows() - 1)
    }
}

/// `x^2 y` at a place.
fn power(monomial: &str, x: f64, y: f64) -> f64 {
    let factor = |word: &str| {
        let (base, exponent) = word.split_once('^').unwrap_or((word, "1"));
        let base = if base == "x" { x } else { y };
        base.powi(exponent.parse().expect("an exponent"))
    };
    monomial.split(' ').map(factor).product()
}

/// A small translation and rotation of the body that carries the point, about the body's centroid.
fn add_body(source: &mut [f64], moved: &Value, table: &Table, row: usize, uses: &[bool]) {
    let all = points(table, "from");
    let bodies = table.texts("body");
    let body = &bodies[row];
    let of_body: Vec<&Vec<f64>> =
        (0..all.len()).filter(|&i| uses[i] && bodies[i] == *body).map(|i| &all[i]).collect();
    let centre = mean(&of_body);
    let arm: Vec<f64> = all[row].iter().zip(&centre).map(|(a, b)| a - b).collect();
    let names = &["x", "y", "z"][..arm.len()];
    for (k, axis) in names.iter().enumerate() {
        source[k] += amplitude(moved, &format!("{body} {axis}"));
    }
    for a in 0..arm.len() {
        for b in a + 1..arm.len() {
            let angle = amplitude(moved, &format!("{body} {} to {}", names[a], names[b])) * 1e-6;
            source[a] -= angle * arm[b];
            source[b] += angle * arm[a];
        }
    }
}

/// Identity and what scales, shears and a mirror add to it in the first frame.
fn strained(json: &Value, n: usize) -> Vec<Vec<f64>> {
    let mut strained: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|k| if i == k { 1.0 } else { 0.0 }).collect()).collect();
    let names = &["x", "y", "z"][..n];
    if let Some(scale) = step(json, "scale", None) {
        for (k, row) in strained.iter_mut().enumerate() {
            row[k] += amplitude(scale, "scale") * 1e-6;
        }
    }
    if let Some(scales) = step(json, "anisotropic-scale", None) {
        for (k, axis) in names.iter().enumerate() {
            strained[k][k] += amplitude(scales, axis) * 1e-6;
        }
    }
    if let Some(shear) = step(json, "shear", None) {
        for a in 0..n {
            for b in a + 1..n {
                strained[a][b] += amplitude(shear, &format!("{}{}", names[a], names[b])) * 1e-6;
            }
        }
    }
    strained
}

fn linear(matrix: &[Vec<f64>], n: usize) -> Vec<Vec<f64>> {
    matrix[..n].iter().map(|row| row[..n].to_vec()).collect()
}

fn times(a: &[Vec<f64>], b: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = a.len();
    let entry = |i: usize, k: usize| (0..n).map(|j| a[i][j] * b[j][k]).sum();
    (0..n).map(|i| (0..n).map(|k| entry(i, k)).collect()).collect()
}

/// Gauss and Jordan; these matrices are near the identity.
fn inverse(matrix: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = matrix.len();
    let mut rows: Vec<Vec<f64>> = (matrix.iter().enumerate())
        .map(|(i, row)| {
            let unit = (0..n).map(|k| if i == k { 1.0 } else { 0.0 });
            row.iter().copied().chain(unit).collect()
        })
        .collect();
    for pivot in 0..n {
        let lead = rows[pivot][pivot];
        rows[pivot].iter_mut().for_each(|v| *v /= lead);
        let pivoted = rows[pivot].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(i, _)| *i != pivot) {
            let factor = row[pivot];
            row.iter_mut().zip(&pivoted).for_each(|(v, p)| *v -= factor * p);
        }
    }
    rows.into_iter().map(|row| row[n..].to_vec()).collect()
}

fn mean(points: &[&Vec<f64>]) -> Vec<f64> {
    let n = points[0].len();
    (0..n)
        .map(|k| points.iter().map(|p| p[k]).sum::<f64>() / crate::handback::as_f64(points.len()))
        .collect()
}

fn distance2(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum()
}
