//! Mistakes beside something else that is wrong.

use super::{SURVEY, change, first, fixture, survey, swap};
use crate::command::Case;

const LOG: &str = "log.csv";
const RANGES: &str = "ranges.csv";

fn names(answer: &serde_json::Value) -> Vec<String> {
    let steps = answer["steps"].as_array().unwrap();
    steps.iter().map(|step| step["effect"].as_str().unwrap().to_owned()).collect()
}

/// Adds to one number.
fn add(case: &Case, file: &str, column: &str, row: usize, by: f64) {
    change(case, file, &[column], |n, old| {
        let read: f64 = old[n][0].parse().unwrap();
        vec![format!("{}", if n == row { read + by } else { read })]
    });
}

/// With the columns exchanged back the one reading is left, which no physics of a head explains.
#[test]
fn a_reading_far_off_does_not_hide_exchanged_columns() {
    let case = fixture("force-impedance/nothing-coloured", &["case.toml", LOG]);
    swap(&case, LOG, ["f1_n", "f2_n"]);
    add(&case, LOG, "reference_n", 165, 60.0);
    let (_, answer) = first(&case);
    assert_eq!(names(&answer), ["input:exchanged", "input:spike"], "{}", answer["steps"]);
    assert_eq!(answer["steps"][0]["subject"], "log.csv: f1_n, f2_n");
}

/// The free error of every angle takes up the whole turn, so that nothing of it is in χ².
#[test]
fn a_bad_range_does_not_hide_a_reversed_axis() {
    let case = fixture("tracker-lm/nothing", &["case.toml", "stations.csv", "mounts.csv", RANGES]);
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    let turned = text.replace(
        "[-0.000325260692885, 0.999999604999856, 0.000827167222741]",
        "[0.000325260692885, -0.999999604999856, -0.000827167222741]",
    );
    assert_ne!(turned, text);
    case.write("case.toml", turned);
    add(&case, RANGES, "displacement_mm", 70, 0.05);
    let (_, answer) = first(&case);
    assert_eq!(names(&answer), ["input:direction", "bad-point"], "{}", answer["steps"]);
}

/// What comes last before it is read first, at the start of its first lock; where that is left to the dead path of the
/// lock, most of its rows still fit none of their own.
#[test]
fn rows_of_one_station_are_shifted_back_together() {
    let case = fixture("tracker-lm/nothing", &["case.toml", "stations.csv", "mounts.csv", RANGES]);
    change(&case, RANGES, &["displacement_mm"], |n, old| {
        let of = if (228..304).contains(&n) { 228 + (n - 228 + 75) % 76 } else { n };
        old[of].clone()
    });
    let ended = case.run("loop");
    let said = "`displacement_mm` of ranges.csv are shifted one row down from line 230 to line 305";
    assert!(ended.stderr.contains(said), "{}", ended.stderr);
}

#[test]
fn a_channel_that_clips_at_one_end_is_named_alone() {
    let case = fixture("ft-center/nothing-coloured", &["case.toml", "presses.csv", "wrench.csv"]);
    let text = std::fs::read_to_string(case.file("wrench.csv")).unwrap();
    let read = |line: &str| line.split(',').nth(5).unwrap().parse::<f64>().unwrap();
    let mut all: Vec<f64> = text.lines().skip(1).map(read).collect();
    all.sort_by(f64::total_cmp);
    let limit = all[all.len() * 17 / 20];
    change(&case, "wrench.csv", &["mx_nmm"], |n, old| {
        vec![format!("{}", old[n][0].parse::<f64>().unwrap().min(limit))]
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:saturation", "{step}");
    assert_eq!(step["subject"], "wrench.csv: mx_nmm");
}

/// Five nanometres, of readings that scatter by five micrometres and go with nothing.
#[test]
fn noise_declared_in_another_unit_is_named_and_hides_no_bad_point() {
    let case = survey();
    case.write("case.toml", SURVEY.replace("0.005", "0.000005"));
    let (step, answer) = first(&case);
    assert_eq!(names(&answer), ["input:unit"], "{}", answer["steps"]);
    assert_eq!(step["subject"], "case.toml: [noise] point_mm");
    add(&case, "pairs.csv", "to_x_mm", 4, 0.2);
    let (step, answer) = first(&case);
    assert_eq!(names(&answer), ["input:unit", "bad-point"], "{}", answer["steps"]);
    assert_eq!(step["subject"], "case.toml: [noise] point_mm");
}
