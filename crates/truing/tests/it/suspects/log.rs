//! Mistakes in logs and strokes of a polishing head.

use super::{change, first, fixture, swap};
use crate::command::Case;

fn log(name: &str) -> Case {
    fixture(&format!("force-impedance/{name}"), &["case.toml", "log.csv"])
}

/// The reference as it would have been read at other times, s after those of its rows, on straight
/// lines within a strip of forty rows.
#[expect(clippy::cast_precision_loss, reason = "counts of rows")]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside a strip")]
fn read_at(case: &Case, later_s: impl Fn(usize) -> f64) {
    change(case, "log.csv", &["reference_n"], |n, old| {
        let read = |row: usize| old[row][0].parse::<f64>().unwrap();
        let strip = n - n % 40;
        let at = ((n - strip) as f64 + later_s(n) * 20.0).clamp(0.0, 38.999);
        let before = strip + at as usize;
        let share = at - at.floor();
        vec![format!("{}", read(before) + share * (read(before + 1) - read(before)))]
    });
}

#[test]
#[expect(clippy::cast_precision_loss, reason = "counts of rows")]
fn a_clock_that_runs_ahead_or_jitters_is_told_from_a_delay() {
    let case = log("nothing-coloured");
    read_at(&case, |_| 0.06);
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:clock");
    assert!(step["description"].as_str().unwrap().contains("ahead of"), "{step}");
    // Where the legs are filtered, the reference reads ahead of them.
    let rivals = step["indistinguishable_from"].as_array().unwrap();
    assert!(rivals.contains(&"delay".into()), "{step}");
    let case = log("nothing-coloured");
    // Up to 0.05 s either way, in an order without memory.
    read_at(&case, |n| 0.05 * (n as f64 * 2.399_963 * n as f64).sin());
    let (step, _) = first(&case);
    assert!(step["description"].as_str().unwrap().contains("jitters"), "{step}");
    let delayed = log("reference-delay").json("loop");
    assert_eq!(delayed["steps"][0]["effect"], "delay", "{delayed}");
}

#[test]
#[expect(clippy::cast_precision_loss, reason = "counts of rows")]
fn a_clock_at_another_rate_is_told_with_the_readings_it_leaves_out() {
    let case = log("nothing-coloured");
    // From right to half a second late, ten of the forty readings of a strip.
    read_at(&case, |n| -0.5 * n as f64 / 400.0);
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:clock");
    assert!(step["description"].as_str().unwrap().contains("another rate"), "{step}");
    // Started anew with every strip, and a tenth slow.
    let case = log("nothing-coloured");
    read_at(&case, |n| -0.1 * (n % 40) as f64 / 20.0);
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:clock");
    let said = step["description"].as_str().unwrap();
    assert!(said.contains("where each stretch of the record begins"), "{said}");
}

#[test]
fn references_of_two_segments_are_exchanged_back() {
    let case = log("nothing-coloured");
    change(&case, "log.csv", &["reference_n"], |n, old| {
        let of = match n / 40 {
            2 => n + 120,
            5 => n - 120,
            _ => n,
        };
        old[of].clone()
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:labels", "{step}");
    assert_eq!(step["subject"], "log.csv: reference_n");
}

#[test]
fn a_channel_that_stands_still_is_stuck_and_not_at_a_limit() {
    let case = log("nothing-coloured");
    change(&case, "log.csv", &["f3_n"], |n, old| vec![old[n.min(200)][0].clone()]);
    assert_eq!(first(&case).0["effect"], "input:stuck");
}

/// An amplifier that clips, with its noise on top of that, before another that does: one limit, and one mistake.
#[test]
fn a_limit_with_noise_on_top_of_it_is_one_mistake() {
    let case = log("nothing-coloured");
    change(&case, "log.csv", &["f4_n"], |n, old| {
        let read: f64 = old[n][0].parse().unwrap();
        let noise = 0.15 * f64::from(u32::try_from(n * n % 97).unwrap()).sin();
        vec![format!("{:.4}", (read.min(64.9) + noise).min(65.0))]
    });
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:saturation");
    assert_eq!(step["subject"], "log.csv: f4_n");
    let steps = answer["steps"].as_array().unwrap();
    let mistakes = steps.iter().filter(|s| s["effect"].as_str().unwrap().starts_with("input:"));
    assert_eq!(mistakes.count(), 1, "{}", answer["steps"]);
}

/// Readings of a strip that lie lower than all others are there for the strip's sake.
#[test]
fn the_lowest_strip_is_no_limit_where_something_else_is_wrong_with_it() {
    let case = log("nothing-coloured");
    change(&case, "log.csv", &["f1_n", "reference_n"], |n, old| {
        let [low, reference] = [0, 1].map(|k| old[n][k].parse::<f64>().unwrap());
        let is_there = (40..80).contains(&n);
        // Ten newtons less in the one cell, in a narrow band, is three in the force.
        let low = if is_there { 47.0 + 0.05 * (low - 47.0) } else { low };
        let reference = if is_there { reference + 3.0 } else { reference };
        vec![format!("{low:.4}"), format!("{reference:.4}")]
    });
    let answer = case.json("loop");
    let steps = answer["steps"].as_array().unwrap();
    assert!(steps.iter().all(|s| s["effect"] != "input:saturation"), "{}", answer["steps"]);
    assert_ne!(answer["verdict"], "nothing-missing");
}

#[test]
fn a_mistake_is_named_beside_physics_that_is_named_after_it() {
    let case = log("head-weight");
    swap(&case, "log.csv", ["f1_n", "f2_n"]);
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:exchanged");
    assert_eq!(answer["steps"][1]["effect"], "head-weight", "{}", answer["steps"]);
}

#[test]
fn references_of_two_strokes_are_exchanged_back() {
    let case = fixture("force-impedance/path-nothing", &["case.toml", "path.csv"]);
    let text = std::fs::read_to_string(case.file("path.csv")).unwrap();
    let n = text.lines().filter(|line| line.starts_with("stroke 1,")).count();
    change(&case, "path.csv", &["reference_n"], |row, old| {
        let from = match row / n {
            0 => row + n,
            1 => row - n,
            _ => row,
        };
        old[from].clone()
    });
    assert_eq!(first(&case).0["effect"], "input:labels");
}

#[test]
fn a_reference_that_stands_still_is_stuck() {
    let case = log("nothing-coloured");
    change(&case, "log.csv", &["reference_n"], |n, old| vec![old[n.min(350)][0].clone()]);
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:stuck", "{step}");
    assert!(step["subject"].as_str().unwrap().contains("reference_n"), "{step}");
}

/// Friction of thirty times what there is, and a force that goes against itself, would explain it.
#[test]
fn a_reference_of_another_session_is_no_friction() {
    let case = log("nothing-coloured");
    change(&case, "log.csv", &["reference_n"], |n, old| old[(n * 389 + 131) % old.len()].clone());
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:unmatched");
    assert_eq!(answer["steps"].as_array().unwrap().len(), 1);
}

/// Both head for the same loads, and hold them each in its way.
#[test]
#[expect(clippy::cast_precision_loss, reason = "counts of rows")]
fn a_reference_of_another_run_at_the_same_loads_is_told() {
    let case = log("nothing-coloured");
    change(&case, "log.csv", &["reference_n"], |n, old| {
        let strip = &old[n - n % 40..][..40];
        let load = strip.iter().map(|cells| cells[0].parse::<f64>().unwrap()).sum::<f64>() / 40.0;
        let at = n as f64;
        let held = 1.0 + 0.1 * (0.37 * at).sin() * (0.0011 * at * at).cos();
        vec![format!("{:.3}", load * held)]
    });
    assert_eq!(first(&case).0["effect"], "input:unmatched");
}

/// Where the log went on between strips, a clock that is late does the same.
#[test]
fn a_column_some_rows_further_down_is_no_delay() {
    const DOWN: usize = 7;
    for columns in [&["reference_n"][..], &["f1_n", "f2_n", "f3_n", "f4_n"]] {
        let case = log("nothing-coloured");
        change(&case, "log.csv", columns, |n, old| old[(n + old.len() - DOWN) % old.len()].clone());
        let (step, answer) = first(&case);
        let said = format!("{} {}", step["description"], step["indistinguishable_from"]);
        let name = format!("input:row-shift [log.csv: {}]", columns.join(", "));
        let is_named = step["effect"] == "input:row-shift" || said.contains(&name);
        assert!(is_named && said.contains("shifted 7 rows down"), "{step}");
        assert_eq!(answer["steps"].as_array().unwrap().len(), 1);
    }
}

#[test]
fn a_cell_that_reads_what_another_reads_is_a_copy() {
    let case = log("nothing-coloured");
    change(&case, "log.csv", &["f1_n", "f3_n"], |n, old| {
        vec![old[n][0].clone(), old[n][0].clone()]
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:copied");
    assert_eq!(step["subject"], "log.csv: f1_n, f3_n");
}

#[test]
fn the_mean_of_every_segment_is_no_reference() {
    let case = log("nothing-coloured");
    change(&case, "log.csv", &["segment", "reference_n"], |n, old| {
        let same: Vec<f64> = (old.iter().filter(|row| row[0] == old[n][0]))
            .map(|row| row[1].parse().unwrap())
            .collect();
        let mean = same.iter().sum::<f64>() / f64::from(u32::try_from(same.len()).unwrap());
        vec![old[n][0].clone(), format!("{mean:.6}")]
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:stuck");
    assert!(step["description"].as_str().unwrap().contains("in every segment"), "{step}");
}

#[test]
fn half_of_a_log_seven_rows_up_is_named_with_its_lines() {
    let case = log("nothing-coloured");
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    case.write("case.toml", text + "\n[noise]\nforce_n = 0.2\n");
    change(&case, "log.csv", &["reference_n"], |n, old| {
        let from = if 2 * n > old.len() { (n + 7).min(old.len() - 1) } else { n };
        old[from].clone()
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:row-shift");
    assert!(step["description"].as_str().unwrap().contains("7 rows up"), "{step}");
}

/// A signal that goes up and down is no better with half of the delay.
#[test]
fn a_cell_that_comes_late_by_many_samples_is_shifted_back() {
    let case = fixture("force-impedance/nothing-coloured", &["case.toml", "log.csv"]);
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    case.write("case.toml", text + "\n[noise]\nforce_n = 0.2\n");
    change(&case, "log.csv", &["f2_n"], |n, old| old[n.saturating_sub(LATE)].clone());
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:row-shift", "{step}");
    let said = step["description"].as_str().unwrap();
    assert!(said.contains("`f2_n`") && said.contains(&format!("{LATE} rows down")), "{said}");
}

/// Samples by which a cell comes late.
const LATE: usize = 9;

#[test]
fn an_amplifier_on_another_range_is_no_other_unit() {
    let case = fixture("force-impedance/nothing-coloured", &["case.toml", "log.csv"]);
    change(&case, "log.csv", &["reference_n"], |n, old| {
        let read: f64 = old[n][0].parse().unwrap();
        vec![format!("{:.6}", if 5 * n > 3 * old.len() { 0.1 * read } else { read })]
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:decimal-point", "{step}");
    assert!(step["description"].as_str().unwrap().contains("multiply these by 10"), "{step}");
}

/// The plugs of two cells exchanged while the log went on: a misfit of some sigmas, and no more.
#[test]
fn two_cells_exchanged_from_somewhere_to_the_end_are_exchanged_back() {
    let case = log("nothing-coloured");
    change(&case, "log.csv", &["f1_n", "f3_n"], |n, old| {
        let [one, three] = [&old[n][0], &old[n][1]];
        if n < 200 { vec![one.clone(), three.clone()] } else { vec![three.clone(), one.clone()] }
    });
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    case.write("case.toml", text + "\n[noise]\nforce_n = 0.2\n");
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:exchanged", "{step}");
    assert_eq!(step["subject"], "log.csv: f1_n, f3_n");
}

/// A component of the normal a row further down: the lengths that are not one say which.
#[test]
fn a_component_that_comes_a_row_late_is_the_cause_of_normals_of_another_length() {
    let case = log("nothing-coloured");
    change(&case, "log.csv", &["ny"], |n, old| old[(n + old.len() - 3) % old.len()].clone());
    let message = case.message("loop", 2);
    assert!(message.contains("expected a unit vector"), "{message}");
    let cause = "the rows of `ny` of log.csv are shifted 3 rows down against the other columns: shift them back";
    assert!(message.contains(cause), "{message}");
}

#[test]
fn a_reference_as_differences_is_added_up() {
    let case = log("nothing-coloured");
    change(&case, "log.csv", &["reference_n"], |n, old| {
        let read = |row: usize| old[row][0].parse::<f64>().unwrap();
        vec![format!("{:.4}", if n == 0 { read(0) } else { read(n) - read(n - 1) })]
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:increments", "{step}");
    assert_eq!(step["subject"], "log.csv: reference_n");
}

/// Among dozens of units of each cell one takes most of what a segment is off by: it leaves that segment worse than the
/// others.
#[test]
fn a_segment_that_lies_apart_is_no_other_unit_of_a_cell() {
    let case = log("nothing-coloured");
    change(&case, "log.csv", &["reference_n", "segment"], |n, old| {
        let off = if old[n][1] == "strip 1" { 1.9 } else { 0.0 };
        vec![format!("{}", old[n][0].parse::<f64>().unwrap() + off), old[n][1].clone()]
    });
    let answer = case.json("loop");
    let steps = answer["steps"].as_array().unwrap();
    let unit = steps.iter().find(|step| step["effect"] == "input:unit");
    assert!(unit.is_none(), "{steps:?}");
    assert_ne!(answer["verdict"], "nothing-missing");
}

/// The legs of cells and lengths are counted from another one than the angles are.
#[test]
fn legs_in_another_numbering_are_named_with_their_angles() {
    let case = log("nothing-coloured");
    case.replace("case.toml", "[90.0, 210.0, 330.0]", "[330.0, 90.0, 210.0]");
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:exchanged", "{}", answer["steps"]);
    let said = step["description"].as_str().unwrap();
    assert!(said.contains("leg_angles_deg") && said.contains("[90.0, 210.0, 330.0]"), "{said}");
}
