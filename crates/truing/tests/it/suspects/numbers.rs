//! Numbers written, kept or recorded otherwise than their column says.

use super::{SURVEY, change, first, fixture, scale, survey};
use crate::command::Case;

const TO: [&str; 3] = ["to_x_mm", "to_y_mm", "to_z_mm"];

fn read(cell: &str) -> f64 {
    cell.parse().unwrap()
}

/// A sound axis: five cycles there and back over ten targets, no two readings alike.
pub(super) fn axis() -> Case {
    let row = |i: i32| {
        let (cycle, k) = (i / 20, i % 20);
        let (at, way) = if k < 10 { (k, "+") } else { (19 - k, "-") };
        let at = 47.0 * f64::from(at) + 5.0;
        let noise = 0.001 * (1e5 * (12.9898 * f64::from(i)).sin()).fract();
        format!("{at},{:.7},{way},{cycle}\n", at + noise)
    };
    let table: String = (0..100).map(row).collect();
    let table = format!("target_mm,actual_mm,direction,cycle\n{table}");
    let settings = "kind = \"positioning\"\n[noise]\ndeviation_mm = 0.0007\n";
    Case::new(&[("case.toml", settings), ("positions.csv", &table)])
}

#[test]
fn a_decimal_comma_lost_in_several_rows_is_named_with_its_lines() {
    let case = survey();
    change(&case, "pairs.csv", &TO[1..2], |n, old| {
        let factor = if n % 9 == 4 { 1e3 } else { 1.0 };
        vec![format!("{}", factor * read(&old[n][0]))]
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:decimal-point");
    let said = step["description"].as_str().unwrap();
    assert!(said.contains("by 3 places in the lines 6, 15,"), "{said}");
}

#[test]
fn polar_coordinates_in_place_of_cartesian_ones_are_named() {
    let case = survey();
    change(&case, "pairs.csv", &["from_x_mm", "from_y_mm"], |n, old| {
        let [x, y] = [read(&old[n][0]), read(&old[n][1])];
        vec![format!("{:.7}", x.hypot(y)), format!("{:.9}", y.atan2(x).to_degrees())]
    });
    assert_eq!(first(&case).0["effect"], "input:polar");
}

#[test]
fn a_coordinate_given_as_a_diameter_is_named() {
    let case = survey();
    scale(&case, "pairs.csv", &TO[..1], 2.0);
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:diameter");
    assert_eq!(step["subject"], "pairs.csv: to_x_mm");
}

/// A column of zeros has no misfit of its own in any unit: numbers made small enough would fit it.
#[test]
fn a_coordinate_that_was_not_recorded_is_stuck() {
    let case = survey();
    case.write("case.toml", SURVEY);
    change(&case, "pairs.csv", &TO[2..], |_, _| vec!["0.0".to_owned()]);
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:stuck");
    assert_eq!(step["subject"], "pairs.csv: to_z_mm");
}

#[test]
fn every_second_reading_that_is_the_one_before_is_stuck() {
    let case = axis();
    assert_ne!(case.json("loop")["verdict"], "input-wrong");
    change(&case, "positions.csv", &["actual_mm"], |n, old| old[n - n % 2].clone());
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:stuck");
    assert!(step["description"].as_str().unwrap().contains("50 readings"), "{step}");
}

#[test]
fn one_run_typed_from_the_wrong_line_is_shifted_back() {
    let case = axis();
    change(&case, "positions.csv", &["actual_mm"], |n, old| {
        let run = 30..40;
        if run.contains(&n) { old[run.start + (n + 1) % 10].clone() } else { old[n].clone() }
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:row-shift");
    assert!(step["description"].as_str().unwrap().contains("from line 32 to line 41"), "{step}");
}

#[test]
fn touches_from_which_the_ball_was_taken_off_already_are_named() {
    let case = fixture("probe-comp/nothing-white", &["case.toml", "touches.csv"]);
    let answer = case.json("solve");
    let contacts = answer["estimates"]["touches"].as_array().unwrap().clone();
    change(&case, "touches.csv", &["x_mm", "y_mm", "z_mm"], |n, _| {
        ["x_mm", "y_mm", "z_mm"].map(|axis| contacts[n][axis].to_string()).to_vec()
    });
    assert_eq!(first(&case).0["effect"], "input:compensated");
}

#[test]
fn a_reference_that_is_twice_what_it_says_or_partly_in_another_unit_is_named() {
    let log = || fixture("force-impedance/nothing-coloured", &["case.toml", "log.csv"]);
    let case = log();
    scale(&case, "log.csv", &["reference_n"], 2.0);
    assert_eq!(first(&case).0["effect"], "input:gain");
    let case = log();
    change(&case, "log.csv", &["reference_n"], |n, old| {
        let factor = if n >= old.len() / 2 { 1.0 / 9.80665 } else { 1.0 };
        vec![format!("{:.6}", factor * read(&old[n][0]))]
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:unit");
    assert!(step["description"].as_str().unwrap().contains("kgf"), "{step}");
}

/// The name of a column may say another unit: what may be wrong with it is the same.
#[test]
fn columns_in_other_units_are_looked_at_alike() {
    let case = axis();
    let text = std::fs::read_to_string(case.file("positions.csv")).unwrap();
    case.write("positions.csv", text.replacen("actual_mm", "actual_in", 1));
    scale(&case, "positions.csv", &["actual_in"], -1.0 / 25.4);
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:sign");
    assert!(answer["after"]["train_rms"].as_f64().unwrap() < 2e-3, "{}", answer["after"]);
    scale(&case, "positions.csv", &["actual_in"], -1.0);
    assert_ne!(case.json("loop")["verdict"], "input-wrong");
    for (factor, unit, mended) in
        [(25.4, "mm instead of inches", "0.03937"), (25.4e3, "µm instead of inches", "e-5")]
    {
        scale(&case, "positions.csv", &["actual_in"], factor);
        let (step, _) = first(&case);
        let text = step["description"].as_str().unwrap();
        assert!(text.starts_with("`actual_in` of positions.csv is in another unit"), "{text}");
        assert!(text.contains(unit) && text.contains(mended), "{text}");
        scale(&case, "positions.csv", &["actual_in"], 1.0 / factor);
    }
}

#[test]
fn readings_that_clip_and_readings_that_are_deviations_are_no_exchanged_rows() {
    let number = |cell: &str| cell.parse::<f64>().unwrap();
    let clipped = axis();
    change(&clipped, "positions.csv", &["actual_mm"], |n, old| {
        vec![format!("{:.7}", number(&old[n][0]).min(397.2))]
    });
    let (step, _) = first(&clipped);
    assert_eq!(step["effect"], "input:saturation", "{step}");
    let mixed = axis();
    change(&mixed, "positions.csv", &["actual_mm", "target_mm", "direction"], |n, old| {
        let [actual, target] = [0, 1].map(|i| number(&old[n][i]));
        let is_back = old[n][2] == "-" && target > 300.0;
        let read = if is_back { actual - target } else { actual };
        vec![format!("{read:.7}"), old[n][1].clone(), old[n][2].clone()]
    });
    let (step, _) = first(&mixed);
    assert_eq!(step["effect"], "input:increments", "{step}");
    let said = step["description"].as_str().unwrap();
    assert!(said.contains("deviations") && said.contains("add the target"), "{said}");
}
