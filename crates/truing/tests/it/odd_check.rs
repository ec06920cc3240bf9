//! A reading that was set aside and is off by itself.

use serde_json::Value;

use crate::command::Case;
use crate::suspects::{change, fixture};

const CASE: &str = "case.toml";
/// What checks is every fourth row.
const ROW: usize = 11;

/// A sound case in which one number of a check reading is off.
fn off(name: &str, files: &[&str], column: &str, by_mm: f64) -> (Case, String) {
    let case = fixture(name, files);
    let table = files[1];
    let text = std::fs::read_to_string(case.file(table)).unwrap();
    let row = text.lines().filter(|line| !line.starts_with('#')).nth(ROW + 1).unwrap();
    assert!(row.contains("check"), "{row}");
    let reading = row.split(',').next().unwrap().to_owned();
    change(&case, table, &[column], |n, old| {
        let read: f64 = old[n][0].parse().unwrap();
        vec![format!("{:.6}", if n == ROW { read + by_mm } else { read })]
    });
    (case, reading)
}

fn held_out(answer: &Value, when: &str) -> f64 {
    answer[when]["held_out_rms"].as_f64().unwrap()
}

/// Nothing that is fitted shows it, and all others say that it is alone.
#[test]
fn a_check_reading_far_off_is_a_bad_reading() {
    for (name, files, column, by_mm, effect) in [
        ("frame-fit/nothing-white", &[CASE, "pairs.csv"][..], "to_y_mm", 0.2, "bad-point"),
        ("pose-icp/nothing-white", &[CASE, "points.csv", "edge.csv"], "z_mm", 0.03, "bad-point"),
        ("probe-comp/nothing-white", &[CASE, "touches.csv"], "z_mm", 0.03, "bad-point"),
    ] {
        let (case, reading) = off(name, files, column, by_mm);
        let answer = case.json("loop");
        let steps = answer["steps"].as_array().unwrap();
        assert_eq!(steps.len(), 1, "{name}: {steps:?} {}", answer["remaining"]);
        assert_eq!(steps[0]["effect"], effect, "{name}");
        assert_eq!(steps[0]["subject"], reading, "{name}");
        assert_eq!(answer["verdict"], "explained", "{name}: {}", answer["remaining"]);
        assert!(held_out(&answer, "after") < held_out(&answer, "before"), "{name}");
        let said = answer["warnings"][0].as_str().unwrap();
        assert!(said.starts_with(&format!("`{reading}` in line")), "{said}");
    }
}

/// Two of them are no accident: something is missing where they lie.
#[test]
fn two_check_readings_far_off_are_structure() {
    let files = [CASE, "pairs.csv"];
    let (case, _) = off("frame-fit/nothing-white", &files, "to_y_mm", 0.2);
    change(&case, "pairs.csv", &["to_z_mm"], |n, old| {
        let read: f64 = old[n][0].parse().unwrap();
        vec![format!("{:.6}", if n == ROW + 4 { read - 0.15 } else { read })]
    });
    let answer = case.json("loop");
    assert_eq!(answer["verdict"], "structure-remains");
    assert_eq!(answer["remaining"][0]["covariate"], "check groups");
}
