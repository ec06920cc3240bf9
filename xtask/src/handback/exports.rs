//! Tables that other programs read say what the JSON says.

use serde_json::Value;

use crate::handback::AGREEMENT;
use crate::handback::folder::{Folder, Table};
use crate::handback::loops::{amplitude, exported, step};
use crate::kinds::tracker_lm::handback::ERRORS;

/// Half of the last of nine decimals of a degree.
const LAST_DIGIT_DEG: f64 = 0.5e-9;

#[test]
fn exported_errors_and_compensations_of_an_axis_are_those_that_are_printed() {
    let tables = [("--errors", "errors.csv"), ("--compensation", "axis.comp")];
    let mut written = 0;
    for folder in Folder::committed("tracker-lm") {
        let Some((json, [errors, compensation])) = exported(&folder, tables) else { continue };
        assert_errors(&folder, &json, &Table::of(&errors));
        assert_compensation(&folder, &json, &compensation);
        written += 1;
    }
    assert!(written > 0, "no case has a correction");
}

/// Every error and its standard uncertainty, by the names of ISO 230.
fn assert_errors(folder: &Folder, json: &Value, table: &Table) {
    let letter = letter(folder);
    for (row, error) in ascending(json).into_iter().enumerate() {
        for name in ERRORS {
            // `e_x_mm` is `EXB_mm`.
            let (_, rest) = name.split_once('_').expect("an error");
            let (axis, unit) = rest.split_once('_').expect("with a unit");
            let column = format!("E{}{letter}_{unit}", axis.to_uppercase());
            let std = (format!("std_{column}"), &error[format!("std_{name}")]);
            for (column, printed) in [(column, &error[name]), std] {
                let written = table.numbers(&column)[row];
                let printed = printed.as_f64().expect("a number");
                let allowed = AGREEMENT * printed.abs();
                assert!((written - printed).abs() <= allowed, "{}: {column}", folder.name());
            }
        }
    }
}

/// The axis' rotation about itself, and its reversal between the two ways.
fn assert_compensation(folder: &Folder, json: &Value, text: &str) {
    let letter = letter(folder);
    let own = format!("e_{}_rad", letter.to_lowercase());
    let reversal = step(json, "backlash", None)
        .map_or(0.0, |play| 1e-6 * amplitude(play, &format!("E{letter}{letter}")));
    for (line, error) in text.lines().zip(ascending(json)) {
        let triplet: Vec<f64> = line.split(' ').map(|v| v.parse().expect("a number")).collect();
        let at = error["angle_deg"].as_f64().expect("a number");
        let is = error[&own].as_f64().expect("a number");
        let ways = [0.5, -0.5].map(|way| at + (is + way * reversal).to_degrees());
        for (written, printed) in triplet.iter().zip([at, ways[0], ways[1]]) {
            let allowed = LAST_DIGIT_DEG + f64::EPSILON * printed.abs();
            assert!((written - printed).abs() <= 2.0 * allowed, "{}: {line}", folder.name());
        }
    }
}

fn letter(folder: &Folder) -> String {
    folder.document()["axis"]["letter"].as_str().expect("a letter").to_owned()
}

fn ascending(json: &Value) -> Vec<&Value> {
    let mut all: Vec<&Value> =
        json["estimates"]["axis_errors"].as_array().expect("errors").iter().collect();
    let angle = |error: &Value| error["angle_deg"].as_f64().expect("a number");
    all.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    all
}
