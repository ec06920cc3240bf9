//! Mistakes in positions of an axis.

use serde_json::Value;

use super::{change, first, fixture, scale, survey, swap};
use crate::command::Case;

/// A sound axis, six rounds of eight targets.
fn axis() -> Case {
    let row = |i: i32| {
        let at = f64::from(i % 8) * 50.0 + 3.0;
        // Digits of a sine far behind the point: no wave along the order.
        let noise = 0.001 * (1e5 * (12.9898 * f64::from(i)).sin()).fract();
        format!("{at},{:.7},{},{}\n", at + noise, if i / 8 % 2 == 0 { "+" } else { "-" }, i / 16)
    };
    let table: String = (0..48).map(row).collect();
    let table = format!("target_mm,actual_mm,direction,cycle\n{table}");
    Case::new(&[
        ("case.toml", "kind = \"positioning\"\n[noise]\ndeviation_mm = 0.001\n"),
        ("positions.csv", &table),
    ])
}

/// Values evenly spread over ±0.5, of either side: multiples of the golden ratio modulo one.
fn even(n: i32) -> f64 {
    (0.618_033_988_75 * f64::from(n)).fract() - 0.5
}

#[test]
fn positions_in_another_unit_are_no_pitch_error() {
    let case = axis();
    assert_eq!(case.json("check")["suspects"], Value::Array(Vec::new()));
    scale(&case, "positions.csv", &["actual_mm"], 1.0 / 25.4);
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:unit");
    assert_eq!(step["subject"], "positions.csv: actual_mm");
}

/// Targets divided by the inch fit what was read in inches still better: both are small then.
#[test]
fn a_unit_of_some_rows_is_of_what_was_read_in_it() {
    let case = axis();
    change(&case, "positions.csv", &["actual_mm"], |n, old| {
        let read: f64 = old[n][0].parse().unwrap();
        vec![format!("{:.7}", if n < 24 { read } else { read / 25.4 })]
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:unit");
    assert_eq!(step["subject"], "positions.csv: actual_mm");
    let said = step["description"].as_str().unwrap();
    assert!(said.contains("from line 26 to line 49"), "{said}");
}

#[test]
fn a_table_in_metres_shows_by_its_noise_alone() {
    let case = axis();
    scale(&case, "positions.csv", &["target_mm", "actual_mm"], 1e-3);
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:unit");
    let said = format!("{} {}", step["description"], step["indistinguishable_from"]);
    assert!(said.contains("metres") && said.contains("deviation_mm"), "{said}");
    assert!(said.contains("µm"), "{said}");
    let rms = answer["before"]["train_rms"].as_f64().unwrap();
    assert!(rms < 1e-5, "{rms}");
}

/// An error of its own at every target would explain it.
#[test]
fn targets_of_another_axis_are_no_pitch_error() {
    let case = axis();
    change(&case, "positions.csv", &["target_mm"], |n, old| {
        vec![format!("{}", 0.7 * old[n][0].parse::<f64>().unwrap() + 11.0)]
    });
    assert_eq!(first(&case).0["effect"], "input:unmatched");
}

/// The fit is as good as before: only what is handed back has the other sign.
#[test]
fn targets_under_the_name_of_positions_are_told_by_coming_again() {
    let case = axis();
    swap(&case, "positions.csv", ["target_mm", "actual_mm"]);
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:exchanged");
    let rms = |of: &Value| of["train_rms"].as_f64().unwrap();
    assert!((rms(&answer["before"]) - rms(&answer["after"])).abs() < 1e-9);
}

/// Targets of the other sign contradict every direction; readings of the other sign contradict none.
#[test]
fn of_mirrored_readings_and_mirrored_targets_each_is_named_alone() {
    for column in ["actual_mm", "target_mm"] {
        let case = axis();
        // There and back.
        change(&case, "positions.csv", &["target_mm", "actual_mm"], |n, old| {
            let of = if n / 8 % 2 == 0 { n } else { n - n % 8 + 7 - n % 8 };
            old[of].clone()
        });
        scale(&case, "positions.csv", &[column], -1.0);
        let (step, answer) = first(&case);
        assert_eq!(step["effect"], "input:sign");
        assert_eq!(step["subject"], format!("positions.csv: {column}"));
        assert_eq!(answer["steps"].as_array().unwrap().len(), 1, "{}", answer["steps"]);
    }
}

#[test]
fn directions_that_all_contradict_the_way_are_turned() {
    let row = |i: i32| {
        let round = i % 16;
        let (at, way) = if round < 8 { (round, "-1") } else { (15 - round, "+1") };
        let at = 50.0 * f64::from(at);
        format!("{at},{:.6},{way}\n", at + 0.001 * (12.9898 * f64::from(i)).sin())
    };
    let table = (0..48).map(row).collect::<String>();
    let table = format!("target_mm,actual_mm,direction\n{table}");
    let settings = "kind = \"positioning\"\n[noise]\ndeviation_mm = 0.001\n";
    let case = Case::new(&[("case.toml", settings), ("positions.csv", &table)]);
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:sign");
    assert_eq!(step["subject"], "positions.csv: direction");
    // One that agrees, and the column may mean another thing.
    case.write("positions.csv", table.replacen("-1\n", "+1\n", 2));
    assert_eq!(case.json("check")["suspects"], Value::Array(Vec::new()));
}

#[test]
fn directions_of_one_cycle_that_contradict_the_way_are_turned_there() {
    let row = |i: i32| {
        let round = i % 16;
        let (at, way) = if round < 8 { (round, 1) } else { (15 - round, -1) };
        let at = 50.0 * f64::from(at);
        let noise = 0.001 * (1e5 * (12.9898 * f64::from(i)).sin()).fract();
        let read = at + 0.01 * f64::from(way) + noise;
        let said = if i / 16 == 1 { -way } else { way };
        format!("{at},{read:.6},{said:+},{}\n", i / 16)
    };
    let table = (0..64).map(row).collect::<String>();
    let table = format!("target_mm,actual_mm,direction,cycle\n{table}");
    let settings = "kind = \"positioning\"\n[noise]\ndeviation_mm = 0.001\n";
    let case = Case::new(&[("case.toml", settings), ("positions.csv", &table)]);
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:sign");
    // The second cycle has rows 16 to 31, below a line of headings.
    assert!(step["description"].as_str().unwrap().contains("of lines 18 to 33,"), "{step}");
    assert_eq!(answer["steps"][1]["effect"], "reversal", "{}", answer["steps"]);
}

#[test]
fn readings_of_a_short_table_that_stand_still_are_stuck() {
    let case = axis();
    change(&case, "positions.csv", &["actual_mm"], |n, old| old[n.min(30)].clone());
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:stuck", "{step}");
    let case = survey();
    change(&case, "pairs.csv", &["to_x_mm"], |n, old| old[n.min(12)].clone());
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:stuck", "{step}");
    assert_eq!(step["subject"], "pairs.csv: to_x_mm");
}

#[test]
fn one_station_in_another_unit_is_named() {
    let files = ["case.toml", "stations.csv", "mounts.csv", "ranges.csv"];
    let case = fixture("tracker-lm/nothing", &files);
    change(&case, "ranges.csv", &["station", "displacement_mm"], |n, old| {
        let mm = old[n][1].parse::<f64>().unwrap();
        vec![old[n][0].clone(), format!("{}", if old[n][0] == "S2" { mm / 1e3 } else { mm })]
    });
    let said = case.run("loop");
    let said = format!("{}{}", said.stdout, said.stderr);
    assert!(said.contains("metres, where `station` is `S2`: multiply these by 1000"), "{said}");
}

/// Five readings, too few to be known by their number: the fit without them tells.
#[test]
fn a_few_readings_that_clip_are_no_bad_points() {
    let case = survey();
    change(&case, "pairs.csv", &["to_x_mm"], |n, old| {
        let read = |row: &Vec<String>| row[0].parse::<f64>().unwrap();
        let mut sorted: Vec<f64> = old.iter().map(read).collect();
        sorted.sort_by(f64::total_cmp);
        vec![format!("{}", read(&old[n]).min(sorted[sorted.len() - 5]))]
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:saturation", "{step}");
    assert_eq!(step["subject"], "pairs.csv: to_x_mm");
}

/// A display that ends at 300 mm: deviations of their own at the last two targets would explain it.
#[test]
fn a_position_that_clips_is_no_profile() {
    let case = axis();
    change(&case, "positions.csv", &["actual_mm"], |n, old| {
        vec![format!("{}", old[n][0].parse::<f64>().unwrap().min(300.0))]
    });
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:saturation");
    assert_eq!(step["subject"], "positions.csv: actual_mm");
    assert!(step["description"].as_str().unwrap().contains("clips at 300 in 12 rows"), "{step}");
    assert_eq!(answer["verdict"], "input-wrong");
}

/// Targets by the scale of the other end: mirrored, with every direction.
#[test]
fn targets_from_the_other_end_are_no_pitch_error() {
    let case = axis();
    change(&case, "positions.csv", &["target_mm", "direction"], |n, old| {
        let target = 356.0 - old[n][0].parse::<f64>().unwrap();
        vec![format!("{target}"), if old[n][1] == "+" { "-" } else { "+" }.to_owned()]
    });
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:direction", "{}", answer["steps"]);
    assert_eq!(answer["steps"].as_array().unwrap().len(), 1, "{}", answer["steps"]);
}

/// Readings of one target have no spread to compare a misfit with, and shifted against it stay what they are.
#[test]
fn readings_of_one_target_are_not_accused() {
    let row = |i: i32| {
        let noise = 0.001 * even(i);
        let (way, at) = if i % 2 == 0 { ("+", 250.0) } else { ("-", 250.006) };
        format!("250,{:.7},{way},{}\n", at + noise, i / 2)
    };
    let table: String = (0..20).map(row).collect();
    let case = Case::new(&[
        ("case.toml", "kind = \"positioning\"\n[noise]\ndeviation_mm = 0.0006\n"),
        ("positions.csv", &format!("target_mm,actual_mm,direction,cycle\n{table}")),
    ]);
    let answer = case.json("loop");
    assert_eq!(answer["steps"][0]["effect"], "reversal", "{}", answer["steps"]);
    assert_eq!(answer["steps"].as_array().unwrap().len(), 1, "{}", answer["steps"]);
}

/// Four positions whose decimal point stands one place too far to the right: no rows in another order.
#[test]
fn positions_with_their_point_elsewhere_are_no_labels() {
    let case = axis();
    change(&case, "positions.csv", &["actual_mm"], |n, old| {
        let value = old[n][0].parse::<f64>().unwrap();
        vec![format!("{:.6}", if [2, 3, 25, 30].contains(&n) { 10.0 * value } else { value })]
    });
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:decimal-point", "{step}");
    assert_eq!(answer["verdict"], "input-wrong");
    assert_eq!(answer["steps"].as_array().unwrap().len(), 1, "{}", answer["steps"]);
}

/// The side that is off is told by most readings: one bad one does not make an offset of it.
#[test]
fn a_bad_reading_does_not_hide_the_side_that_a_reversal_is_of() {
    let case = axis();
    change(&case, "positions.csv", &["actual_mm", "target_mm", "direction"], |n, old| {
        let [_, target, way] = old[n].as_slice() else { unreachable!("three columns") };
        let noise = 0.002 * even(i32::try_from(n).unwrap());
        let off = if way == "-" { 0.006 } else { 0.0 } + if n == 20 { 0.02 } else { 0.0 };
        let read = target.parse::<f64>().unwrap() + noise + off;
        vec![format!("{read:.6}"), target.clone(), way.clone()]
    });
    let answer = case.json("loop");
    let steps = answer["steps"].as_array().unwrap();
    let names: Vec<_> = steps.iter().map(|step| (&step["effect"], &step["subject"])).collect();
    assert!(
        names.iter().any(|(effect, side)| *effect == "reversal" && *side == "falling"),
        "{names:?}"
    );
    assert!(names.iter().any(|(effect, _)| *effect == "bad-point"), "{names:?}");
    assert_eq!(names.len(), 2, "{names:?}");
}

/// A screw of 40 mm, its digits exchanged: 24 targets 7.3 mm apart show a period that is not the declared one.
#[test]
fn a_period_that_is_not_the_screws_says_that_the_lead_may_be_wrong() {
    const LEAD_MM: f64 = 40.0;
    let row = |i: i32| {
        let at = f64::from(i % 24) * 7.3 + 3.0;
        let wave = 0.02 * (std::f64::consts::TAU * at / LEAD_MM).cos();
        // Digits of a sine far behind the point: no wave along the travel.
        let noise = 0.002 * ((1e5 * (12.9898 * f64::from(i)).sin()).fract().abs() - 0.5);
        format!("{at},{:.7},{}\n", at + wave + noise, i / 24)
    };
    let table: String = (0..72).map(row).collect();
    let declared = |lead: f64| {
        let toml = format!(
            "kind = \"positioning\"\n[axis]\nlead_mm = {lead}\n[noise]\ndeviation_mm = 0.0006\n"
        );
        let table = format!("target_mm,actual_mm,cycle\n{table}");
        Case::new(&[("case.toml", &toml), ("positions.csv", &table)]).json("loop")
    };
    let of_lead = |answer: &Value| {
        let steps = answer["steps"].as_array().unwrap();
        assert_eq!(steps.len(), 1, "{}", answer["steps"]);
        assert_eq!(steps[0]["effect"], "cyclic-error");
        steps[0]["description"].as_str().unwrap().contains("see whether `[axis] lead_mm` is right")
    };
    assert!(!of_lead(&declared(LEAD_MM)));
    assert!(of_lead(&declared(15.0)));
}

/// What stands still in the middle of the travel is no limit, and no other order.
#[test]
fn a_position_that_stands_still_in_the_middle_is_stuck() {
    let case = axis();
    change(&case, "positions.csv", &["actual_mm"], |n, old| {
        let held = (n / 7 == 2).then(|| old[14][0].parse::<f64>().unwrap() + [0.0, 1e-4][n % 2]);
        held.map_or_else(|| old[n].clone(), |held| vec![format!("{held}")])
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:stuck", "{step}");
    assert!(step["description"].as_str().unwrap().contains("no limit of the others"), "{step}");
}
