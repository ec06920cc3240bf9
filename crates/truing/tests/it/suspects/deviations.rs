//! Mistakes in deviations of an axis, which are small beside the travel whatever is wrong.

use serde_json::Value;

use super::{change, first, scale};
use crate::command::Case;

const CYCLES: usize = 5;
const TARGETS: usize = 9;

/// Rows of five cycles there and back over nine targets: what is read in µm of target (mm), way and row, and what the
/// column says of the way.
fn axis(read_um: impl Fn(f64, f64, usize) -> f64, said: impl Fn(f64) -> f64) -> Case {
    let rows = (0..2 * TARGETS * CYCLES).map(|row| {
        let round = row % (2 * TARGETS);
        let (at, way) =
            if round < TARGETS { (round, 1.0) } else { (2 * TARGETS - 1 - round, -1.0) };
        #[expect(clippy::cast_precision_loss, reason = "small counts")]
        let [target, n] = [37.3 * at as f64 + 5.0, row as f64];
        // Digits of a sine far behind the point: no wave along the order, 0.6 µm.
        let noise = 2.0 * (1e5 * (12.9898 * n).sin()).fract().abs() - 1.0;
        let read = 1e-3 * (read_um(target, way, row) + noise);
        format!("{target},{read:.5},{},{}\n", said(way), row / (2 * TARGETS))
    });
    let table: String = rows.collect();
    Case::new(&[
        ("case.toml", "kind = \"positioning\"\n[noise]\ndeviation_mm = 0.0006\n"),
        ("positions.csv", &format!("target_mm,deviation_mm,direction,cycle\n{table}")),
    ])
}

/// Rewrites what was read, in mm.
fn read(case: &Case, to: impl Fn(usize, &dyn Fn(usize) -> f64) -> String) {
    change(case, "positions.csv", &["deviation_mm"], |n, old| {
        vec![to(n, &|row| old[row][0].parse().unwrap())]
    });
}

fn effects(answer: &Value) -> Vec<&str> {
    let steps = answer["steps"].as_array().unwrap().iter();
    steps.map(|step| step["effect"].as_str().unwrap()).collect()
}

#[test]
fn deviations_that_clip_are_no_profile() {
    let scale = |target: f64| 0.12 * target;
    let sound = axis(|target, _, _| scale(target), |way| way);
    assert_eq!(effects(&sound.json("loop")), ["pitch-error"]);
    read(&sound, |row, of| format!("{:.5}", of(row).min(0.025)));
    let (step, answer) = first(&sound);
    assert_eq!(step["effect"], "input:saturation", "{step}");
    assert_eq!(effects(&answer), ["input:saturation", "pitch-error"]);
}

#[test]
fn one_direction_in_every_row_is_contradicted_by_a_reversal() {
    let lost = |_: f64, way: f64, _: usize| 9.0 * way;
    let (step, answer) = first(&axis(lost, |_| 1.0));
    assert_eq!(step["effect"], "input:stuck", "{step}");
    assert_eq!(step["subject"], "positions.csv: direction");
    assert_eq!(effects(&answer), ["input:stuck", "reversal"]);
    // An axis that comes from one side alone, wherever it goes next, reads the same.
    let unidirectional = axis(|_, _, _| 0.0, |_| 1.0).json("loop");
    assert!(effects(&unidirectional).is_empty(), "{}", unidirectional["steps"]);
}

#[test]
fn deviations_of_the_other_sign_on_the_way_back_are_no_reversal() {
    let (step, answer) = first(&axis(|target, way, _| 0.07 * target * way, |way| way));
    assert_eq!(step["effect"], "input:sign", "{step}");
    assert_eq!(effects(&answer), ["input:sign", "pitch-error"]);
    // An axis that stops elsewhere from either side, the same everywhere, does the same without a mistake.
    let sound = axis(|_, way, _| 9.0 * way, |way| way).json("loop");
    assert_eq!(effects(&sound), ["reversal"]);
}

#[test]
fn the_last_cycles_of_another_axis_are_told_by_their_rows() {
    let other = |target: f64, way: f64, row: usize| {
        let is_other = row >= 6 * TARGETS;
        if is_other { -0.2 * target + 15.0 * way + 12.0 * (target / 11.0).sin() } else { 0.0 }
    };
    let (step, _) = first(&axis(other, |way| way));
    assert_eq!(step["effect"], "input:misplaced", "{step}");
    // Below a line of headings.
    let said = step["description"].as_str().unwrap();
    assert!(said.contains("to line 91"), "{said}");
}

#[test]
fn a_deviation_that_stands_still_while_the_axis_goes_on_is_stuck() {
    let case = axis(|target, _, _| 0.08 * target, |way| way);
    read(&case, |row, of| format!("{:.5}", of(if (40..52).contains(&row) { 40 } else { row })));
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:stuck", "{step}");
    let said = step["description"].as_str().unwrap();
    assert!(said.contains("in 12 rows one after the other, from line 42,"), "{said}");
    assert_eq!(effects(&answer), ["input:stuck", "pitch-error"]);
}

#[test]
fn deviations_whose_repeats_scatter_a_thousand_times_the_noise_are_in_micrometres() {
    let case = axis(|target, _, _| 0.05 * target, |way| way);
    scale(&case, "positions.csv", &["deviation_mm"], 1e3);
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:unit", "{step}");
    assert_eq!(step["subject"], "positions.csv: deviation_mm");
    assert_eq!(effects(&answer), ["input:unit", "pitch-error"]);
    // The noise declared a thousand times too small is not in the readings.
    scale(&case, "positions.csv", &["deviation_mm"], 1e-3);
    let settings = "kind = \"positioning\"\n[noise]\ndeviation_mm = 0.0000006\n";
    case.write("case.toml", settings);
    let (step, answer) = first(&case);
    assert_eq!(step["subject"], "case.toml: [noise] deviation_mm");
    assert_eq!(effects(&answer), ["input:unit", "pitch-error"]);
}

#[test]
fn deviations_of_a_rotary_axis_in_seconds_under_the_name_of_degrees_are_told_by_their_repeats() {
    let case = axis(|target, _, _| 0.05 * target, |way| way);
    let table = std::fs::read_to_string(case.path().join("positions.csv")).unwrap();
    let table = table.replace("target_mm,deviation_mm", "target_deg,deviation_deg");
    case.write("positions.csv", &table);
    scale(&case, "positions.csv", &["deviation_deg"], 1e3);
    case.write("case.toml", "kind = \"positioning\"\n[noise]\ndeviation_arcsec = 0.6\n");
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:unit", "{step}");
    assert_eq!(step["subject"], "positions.csv: deviation_deg");
    assert!(step["description"].as_str().unwrap().contains("divide by 3600"), "{step}");
    assert_eq!(effects(&answer), ["input:unit", "pitch-error"]);
}

#[test]
fn cycles_that_were_counted_the_other_way_are_named() {
    let turned = |row: usize| [1, 3].contains(&(row / (2 * TARGETS)));
    let of = |target: f64, _: f64, row: usize| 0.09 * target * if turned(row) { -1.0 } else { 1.0 };
    let (step, answer) = first(&axis(of, |way| way));
    assert_eq!(step["effect"], "input:sign", "{step}");
    let said = step["description"].as_str().unwrap();
    assert!(said.contains("where `cycle` is 1, 3:"), "{said}");
    assert_eq!(effects(&answer), ["input:sign", "pitch-error"]);
    // A zero that is elsewhere in these cycles, on the other side, is none.
    let shifted = |_: f64, _: f64, row: usize| if turned(row) { -20.0 } else { 20.0 };
    assert_ne!(axis(shifted, |way| way).json("loop")["verdict"], "input-wrong");
}

#[test]
fn directions_of_several_cycles_that_contradict_the_way_are_turned_there() {
    let case = axis(|_, way, _| 9.0 * way, |way| way);
    let turned = |row: usize| [1, 3].contains(&(row / (2 * TARGETS)));
    change(&case, "positions.csv", &["direction"], |n, old| {
        let said: f64 = old[n][0].parse().unwrap();
        vec![format!("{}", if turned(n) { -said } else { said })]
    });
    let (step, answer) = first(&case);
    assert_eq!(step["subject"], "positions.csv: direction", "{step}");
    let said = step["description"].as_str().unwrap();
    assert!(said.contains("of lines 20 to 37, 56 to 73, and of these alone,"), "{said}");
    assert_eq!(effects(&answer), ["input:sign", "reversal"]);
}

/// Four cycles there and back over twelve targets, with a profile: their deviations further down by some rows, one
/// pass the other way round, and under the name of the targets.
#[test]
fn deviations_in_other_rows_than_they_were_read_in_are_put_back() {
    const TARGETS: i32 = 12;
    const HEADING: &str = "target_mm,deviation_mm,direction,cycle";
    let place = |row: i32| {
        let step = row % (2 * TARGETS);
        if step < TARGETS { (step, "+") } else { (2 * TARGETS - 1 - step, "-") }
    };
    let read: Vec<f64> = (0..8 * TARGETS)
        .map(|row| {
            let at = f64::from(place(row).0);
            let noise = (1e5 * (12.9898 * f64::from(row)).sin()).fract();
            0.02 * (0.7 * at).sin() + 0.0003 * at + 0.0008 * noise
        })
        .collect();
    let table = |heading: &str, deviation: &dyn Fn(usize) -> f64| {
        let row = |(n, row): (usize, i32)| {
            let ((target, way), cycle) = (place(row), row / (2 * TARGETS));
            format!("{:.1},{:.5},{way},{cycle}\n", 37.3 * f64::from(target) + 2.0, deviation(n))
        };
        format!("{heading}\n{}", (0..).zip(0..8 * TARGETS).map(row).collect::<String>())
    };
    let toml = "kind = \"positioning\"\n[noise]\ndeviation_mm = 0.0005\n";
    let case = |table: &str| Case::new(&[("case.toml", toml), ("positions.csv", table)]);
    let sound = case(&table(HEADING, &|n| read[n]));
    assert_eq!(sound.json("check")["suspects"], Value::Array(Vec::new()));
    let n = read.len();
    let shifted = case(&table(HEADING, &|row| read[(row + n - 3) % n]));
    let (step, _) = first(&shifted);
    assert_eq!(step["effect"], "input:row-shift");
    assert!(step["description"].as_str().unwrap().contains("shifted 3 rows down"), "{step}");
    let turned =
        case(&table(HEADING, &|row| read[if (36..48).contains(&row) { 83 - row } else { row }]));
    let (step, _) = first(&turned);
    assert!(
        step["description"].as_str().unwrap().contains("in reverse order from line 38"),
        "{step}"
    );
    let exchanged = case(&table("deviation_mm,target_mm,direction,cycle", &|n| read[n]));
    assert_eq!(first(&exchanged).0["effect"], "input:exchanged");
}

/// A bump at the middle target, met on the way up alone, would lie where the axis turns round, half on either side, with
/// all rows some further on.
#[test]
fn what_one_way_meets_at_a_few_targets_is_no_shift_of_all_rows() {
    let middle = 37.3 * 4.0 + 5.0;
    let bump = |target: f64| 30.0 * (-((target - middle) / 40.0).powi(2)).exp();
    let case = axis(|target, way, _| if way > 0.0 { bump(target) } else { 0.0 }, |way| way);
    let answer = case.json("loop");
    assert_ne!(answer["verdict"], "input-wrong", "{}", answer["steps"]);
}

/// What was read in inches on the way back, where no column says which way that was.
#[test]
fn readings_of_one_way_in_another_unit_are_named_without_a_column_of_directions() {
    let row = |row: i32| {
        let (step, falls) = (row % 10, row / 10 % 2 == 1);
        let at = 31.7 * f64::from(if falls { 9 - step } else { step }) + 4.0;
        let noise = 0.001 * (1e5 * (12.9898 * f64::from(row)).sin()).fract();
        format!("{at:.1},{:.6}\n", (at + noise) / if falls { 25.4 } else { 1.0 })
    };
    let table: String = (0..60).map(row).collect();
    let case = Case::new(&[
        ("case.toml", "kind = \"positioning\"\n[noise]\ndeviation_mm = 0.0006\n"),
        ("positions.csv", &format!("target_mm,actual_mm\n{table}")),
    ]);
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:unit");
    assert!(step["description"].as_str().unwrap().contains("where the axis was falling"), "{step}");
}
