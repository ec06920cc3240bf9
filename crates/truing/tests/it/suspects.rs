//! Mistakes in the input: made in sound cases, and named before any physics.

use std::path::Path;

use serde_json::Value;

use crate::command::Case;

/// A committed case, to make mistakes in.
fn fixture(name: &str, files: &[&str]) -> Case {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(name);
    let text = |file: &str| std::fs::read_to_string(folder.join(file)).unwrap();
    let texts: Vec<(&str, String)> = files.iter().map(|file| (*file, text(file))).collect();
    let texts: Vec<(&str, &str)> = texts.iter().map(|(file, text)| (*file, &**text)).collect();
    Case::new(&texts)
}

fn survey() -> Case {
    fixture("frame-fit/nothing-white", &["case.toml", "pairs.csv"])
}

/// Rewrites the cells of some columns of a table, row by row.
fn change(
    case: &Case,
    file: &str,
    columns: &[&str],
    of: impl Fn(usize, &[Vec<String>]) -> Vec<String>,
) {
    let text = std::fs::read_to_string(case.file(file)).unwrap();
    let cells = |line: &str| -> Vec<String> { line.split(',').map(str::to_owned).collect() };
    let mut lines = text.lines().filter(|line| !line.starts_with('#')).map(cells);
    let header = lines.next().unwrap();
    let mut rows: Vec<Vec<String>> = lines.collect();
    let at: Vec<usize> =
        columns.iter().map(|c| header.iter().position(|h| h == c).unwrap()).collect();
    let old: Vec<Vec<String>> =
        rows.iter().map(|row| at.iter().map(|&i| row[i].clone()).collect()).collect();
    for (n, row) in rows.iter_mut().enumerate() {
        for (&i, cell) in at.iter().zip(of(n, &old)) {
            row[i] = cell;
        }
    }
    let all = std::iter::once(&header).chain(&rows).map(|row| row.join(",") + "\n");
    case.write(file, all.collect::<String>());
}

fn scale(case: &Case, file: &str, columns: &[&str], factor: f64) {
    change(case, file, columns, |n, old| {
        old[n].iter().map(|cell| format!("{}", cell.parse::<f64>().unwrap() * factor)).collect()
    });
}

/// The first step of the loop, which must be about the input.
fn first(case: &Case) -> (Value, Value) {
    let answer = case.json("loop");
    assert_eq!(answer["verdict"], "input-wrong", "{}", answer["steps"]);
    (answer["steps"][0].clone(), answer)
}

#[test]
fn a_column_in_inches_is_named_and_the_loop_goes_on_without_it() {
    let case = survey();
    let sound = case.json("loop");
    scale(&case, "pairs.csv", &["to_x_mm"], 1.0 / 25.4);
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:unit");
    assert_eq!(step["subject"], "pairs.csv: to_x_mm");
    assert!(step["description"].as_str().unwrap().contains("inches"), "{step}");
    let rms = |of: &Value| of["train_rms"].as_f64().unwrap();
    assert!(rms(&answer["before"]) > 1e3 * rms(&answer["after"]));
    // Nine digits of an inch: a nanometre.
    assert!((rms(&answer["after"]) - rms(&sound["after"])).abs() < 1e-6);
    let warnings = answer["warnings"].to_string();
    assert!(warnings.contains("as corrected"), "{warnings}");
}

/// Both lateral forces in pounds look like a machine that moves a fifth as far and a sensor that reads
/// moments four times too large; no machine and no sensor does.
#[test]
fn two_of_three_columns_in_another_unit_are_named() {
    let case = fixture("ft-center/nothing-coloured", &["case.toml", "presses.csv", "wrench.csv"]);
    scale(&case, "wrench.csv", &["fx_n", "fy_n"], 1.0 / 4.448_221_615_260_5);
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:unit");
    assert_eq!(step["subject"], "wrench.csv: fx_n, fy_n");
}

#[test]
fn check_lists_it_and_solve_warns() {
    let case = survey();
    scale(&case, "pairs.csv", &["to_x_mm", "to_y_mm", "to_z_mm"], 1e-3);
    let suspects = case.json("check")["suspects"].clone();
    assert_eq!(suspects[0]["effect"], "input:unit");
    assert!(suspects[0]["description"].as_str().unwrap().contains("metres"), "{suspects}");
    let warning = case.json("solve")["warnings"][0].clone();
    assert!(warning.as_str().unwrap().starts_with("the input looks wrong"), "{warning}");
}

#[test]
fn exchanged_and_mirrored_axes_that_fit_alike_are_all_listed() {
    let case = survey();
    change(&case, "pairs.csv", &["to_x_mm", "to_y_mm"], |n, old| {
        vec![old[n][1].clone(), old[n][0].clone()]
    });
    let (step, _) = first(&case);
    let said = format!("{} {}", step["description"], step["indistinguishable_from"]);
    assert!(said.contains("exchanged") && said.contains("opposite sign"), "{said}");
}

#[test]
fn shifted_rows_and_exchanged_points_are_told_apart() {
    let to = ["to_x_mm", "to_y_mm", "to_z_mm"];
    let case = survey();
    change(&case, "pairs.csv", &to, |n, old| old[(n + old.len() - 1) % old.len()].clone());
    assert_eq!(first(&case).0["effect"], "input:row-shift");
    let case = survey();
    change(&case, "pairs.csv", &to, |n, old| {
        old[[5, 1, 2, 3, 4, 0].get(n).copied().unwrap_or(n)].clone()
    });
    assert_eq!(first(&case).0["effect"], "input:labels");
}

#[test]
fn a_case_that_cannot_be_fitted_and_scatters_more_than_declared_says_why() {
    let case = fixture("ft-center/nothing-coloured", &["case.toml", "presses.csv", "wrench.csv"]);
    // A tenth of the noise that there is.
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    let declared: String =
        text.lines().map(|line| line.to_owned() + "\n").collect::<String>() + NOISE_TOO_SMALL;
    case.write("case.toml", declared);
    scale(&case, "wrench.csv", &["fz_n"], 1.0 / 4.448_221_615_260_5);
    let said = case.run("loop");
    assert!(said.stdout.contains("lbf") || said.stderr.contains("lbf"), "{}", said.stderr);
}

const NOISE_TOO_SMALL: &str = "\n[noise]\nforce_n = 0.001\nmoment_nmm = 0.05\n";

#[test]
fn a_case_that_cannot_be_fitted_says_why() {
    let case = fixture("ft-center/nothing-coloured", &["case.toml", "presses.csv", "wrench.csv"]);
    scale(&case, "wrench.csv", &["mx_nmm", "my_nmm", "mz_nmm"], 1e-3);
    let message = case.message("loop", 2);
    assert!(
        message.contains("still moves") && message.contains("N·m instead of N·mm"),
        "{message}"
    );
}

#[test]
fn sound_cases_and_physics_are_not_accused() {
    for name in ["nothing-white", "nothing-coloured", "bad-point", "shear", "scale", "sag"] {
        let case = fixture(&format!("frame-fit/{name}"), &["case.toml", "pairs.csv"]);
        assert_eq!(case.json("check")["suspects"], Value::Array(Vec::new()), "{name}");
        assert_ne!(case.json("loop")["verdict"], "input-wrong", "{name}");
    }
}

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

#[test]
fn a_mistake_is_named_beside_physics_that_is_named_after_it() {
    let case = log("head-weight");
    change(&case, "log.csv", &["f1_n", "f2_n"], |n, old| {
        vec![old[n][1].clone(), old[n][0].clone()]
    });
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:exchanged");
    assert_eq!(answer["steps"][1]["effect"], "head-weight", "{}", answer["steps"]);
}

#[test]
fn a_quaternion_with_its_scalar_last_is_named() {
    let table = "place,x_mm,y_mm,z_mm,qw,qx,qy,qz\n".to_owned() + &poses();
    let case = Case::new(&[
        ("case.toml", "kind = \"frame-fit\"\n[noise]\npoint_mm = 0.01\n"),
        ("poses.csv", &table),
    ]);
    assert_eq!(case.json("check")["suspects"], Value::Array(Vec::new()));
    case.write("poses.csv", table.replacen("qw,qx,qy,qz", "qx,qy,qz,qw", 1));
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:exchanged");
    assert!(step["description"].as_str().unwrap().contains("scalar part"), "{step}");
}

/// Flange poses whose tip, [10, -20, 150] mm from the flange, touches [400, 100, 50] mm.
#[expect(clippy::cast_precision_loss, reason = "counts of rows")]
fn poses() -> String {
    let pose = |i: usize| {
        let phase = i as f64;
        let angle = 0.5 + 0.3 * (1.7 * phase).sin();
        let axis = [(2.1 * phase).sin(), (1.3 * phase).cos(), 0.4];
        let length = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
        let [x, y, z] = axis.map(|a| a / length * (0.5 * angle).sin());
        let w = (0.5 * angle).cos();
        let tip = [10.0, -20.0, 150.0];
        // t + 2 v × (v × t + w t)
        let v = [x, y, z];
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let inner = cross(v, tip);
        let inner = std::array::from_fn(|k| inner[k] + w * tip[k]);
        let outer = cross(v, inner);
        let noise = |k: f64| 0.01 * ((phase + 1.0) * (k + 1.0) * 12.9898).sin();
        let at: [f64; 3] = std::array::from_fn(|k| {
            [400.0, 100.0, 50.0][k] - tip[k] - 2.0 * outer[k] + noise(k as f64)
        });
        format!("cup,{:.5},{:.5},{:.5},{w:.9},{x:.9},{y:.9},{z:.9}\n", at[0], at[1], at[2])
    };
    (0..14).map(pose).collect()
}

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

#[test]
fn positions_in_another_unit_are_no_pitch_error() {
    let case = axis();
    assert_eq!(case.json("check")["suspects"], Value::Array(Vec::new()));
    scale(&case, "positions.csv", &["actual_mm"], 1.0 / 25.4);
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:unit");
    assert_eq!(step["subject"], "positions.csv: actual_mm");
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

/// A survey's noise in µm is the same mistake; one that is only ten times too large is none.
#[test]
fn noise_in_another_unit_is_told_from_careful_noise() {
    let case = survey();
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    let declared = |value: &str| {
        let line = |line: &str| match line.strip_prefix("point_mm = ") {
            Some(_) => format!("point_mm = {value}\n"),
            None => format!("{line}\n"),
        };
        case.write("case.toml", text.lines().map(line).collect::<String>());
    };
    declared("5.0");
    assert_eq!(first(&case).0["subject"], "case.toml: [noise] point_mm");
    declared("0.05");
    assert_eq!(case.json("check")["suspects"], Value::Array(Vec::new()));
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
    change(&case, "positions.csv", &["target_mm", "actual_mm"], |n, old| {
        vec![old[n][1].clone(), old[n][0].clone()]
    });
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:exchanged");
    let rms = |of: &Value| of["train_rms"].as_f64().unwrap();
    assert!((rms(&answer["before"]) - rms(&answer["after"])).abs() < 1e-9);
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

/// Two bad readings explain it as well, but need a number each.
#[test]
fn heights_of_two_points_are_each_others_and_not_two_bad_ones() {
    let case = fixture("pose-icp/nothing-white", &["case.toml", "points.csv", "edge.csv"]);
    assert_eq!(case.json("check")["suspects"], Value::Array(Vec::new()));
    change(&case, "points.csv", &["z_mm"], |n, old| {
        old[[9, 1, 2, 3, 4, 5, 6, 7, 8, 0].get(n).copied().unwrap_or(n)].clone()
    });
    assert_eq!(first(&case).0["effect"], "input:labels");
}

/// A touch that lies far off is refused, and the refusal looks for the one that it was mistaken for.
#[test]
fn a_touch_with_the_height_of_another_is_refused_with_both_lines() {
    let case = fixture("probe-comp/lobing", &["case.toml", "touches.csv"]);
    let text = std::fs::read_to_string(case.file("touches.csv")).unwrap();
    let heights: Vec<f64> = text
        .lines()
        .filter(|line| line.starts_with('T'))
        .map(|line| line.split(',').nth(3).unwrap().parse().unwrap())
        .collect();
    let at = |best: fn(f64, f64) -> bool| {
        (0..heights.len()).reduce(|a, b| if best(heights[b], heights[a]) { b } else { a }).unwrap()
    };
    let (low, high) = (at(|b, a| b < a), at(|b, a| b > a));
    change(&case, "touches.csv", &["z_mm"], |n, old| {
        let from = if n == low {
            high
        } else if n == high {
            low
        } else {
            n
        };
        old[from].clone()
    });
    let message = case.message("loop", 2);
    let lines = format!("in lines {} and {}", low.min(high) + 2, low.max(high) + 2);
    assert!(message.contains("are exchanged") && message.contains(&lines), "{message}");
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

/// Readings of a tracker that goes round all reflectors at every stop, one row further down.
#[test]
fn a_whole_table_one_row_down_is_named() {
    let files = ["case.toml", "stations.csv", "mounts.csv", "targets.csv"];
    let case = fixture("tracker-lm/targets-nothing", &files);
    let place = ["x_mm", "y_mm", "z_mm"];
    change(&case, "targets.csv", &place, |n, old| old[(n + old.len() - 1) % old.len()].clone());
    assert_eq!(first(&case).0["effect"], "input:row-shift");
}

/// Friction of thirty times what there is, and a force that goes against itself, would explain it.
#[test]
fn a_reference_of_another_session_is_no_friction() {
    let case = log("nothing-coloured");
    change(&case, "log.csv", &["reference_n"], |n, old| old[(n * 389 + 131) % old.len()].clone());
    let answer = case.json("loop");
    assert_eq!(answer["verdict"], "structure-remains");
    assert_eq!(answer["steps"], Value::Array(Vec::new()));
}

#[test]
fn wrenches_of_another_session_belong_to_no_poses() {
    let case = fixture("ft-center/measured-wheel", &["case.toml", "gravity.csv"]);
    let wrench = ["fx_n", "fy_n", "fz_n", "mx_nmm", "my_nmm", "mz_nmm"];
    change(&case, "gravity.csv", &wrench, |n, old| old[(n * 7 + 3) % old.len()].clone());
    assert_eq!(first(&case).0["effect"], "input:unmatched");
}

/// Samples between two of a short record, so that it has more than are tried one by one.
const BETWEEN: u32 = 16;

/// Presses of a long record, as its columns are headed.
fn long_record(header: &str) -> Case {
    let case = fixture(
        "ft-center/nothing-coloured",
        &["case.toml", "presses.csv", "wrench.csv", "provenance.toml"],
    );
    let short = std::fs::read_to_string(case.file("wrench.csv")).unwrap();
    let mut long = header.to_owned() + "\n";
    for (n, line) in (0..).zip(short.lines().skip(1)) {
        let cells: Vec<&str> = line.split(',').collect();
        let numbers: Vec<f64> = cells[1..].iter().map(|cell| cell.parse().unwrap()).collect();
        for k in 0..BETWEEN {
            // Noise of a last digit, so that no channel stands still.
            let digit = 1e-4 * f64::from((7 * n + 13 * k) % 17);
            long += &format!("{},{:.5}", cells[0], numbers[0] + 0.00125 * f64::from(k));
            long.extend(numbers[1..].iter().map(|value| format!(",{:.4}", value + digit)));
            long.push('\n');
        }
    }
    case.write("wrench.csv", long);
    case
}

#[test]
fn what_some_samples_of_a_long_record_show_is_said_of_all() {
    let sound = long_record("press,time_s,fx_n,fy_n,fz_n,mx_nmm,my_nmm,mz_nmm").json("solve");
    let case = long_record("press,time_s,fx_n,fy_n,fz_n,my_nmm,mx_nmm,mz_nmm");
    let warning = case.json("solve")["warnings"][0].as_str().unwrap().to_owned();
    assert!(warning.contains("`mx_nmm`, `my_nmm` of wrench.csv are exchanged"), "{warning}");
    let presses = sound["estimates"]["centers"].as_array().unwrap();
    let offset_mm = |press: &Value| {
        let side = |name: &str| press[name].as_f64().unwrap();
        side("offset_x_mm").hypot(side("offset_y_mm"))
    };
    let square: f64 = presses.iter().map(|press| offset_mm(press).powi(2)).sum();
    let rms_mm = (square / f64::from(u32::try_from(presses.len()).unwrap())).sqrt();
    let after = warning.split("with that change ").nth(1).unwrap().split(" mm").next().unwrap();
    let after_mm: f64 = after.parse().unwrap();
    // It is written with five digits.
    assert!((after_mm / rms_mm - 1.0).abs() < 1e-4, "{after_mm} and {rms_mm}: {warning}");
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

/// A tracker that has lost its reflector goes on sending the last place.
#[test]
fn places_that_stand_still_are_named_though_nothing_can_be_fitted() {
    let files = ["case.toml", "stations.csv", "mounts.csv", "targets.csv"];
    let case = fixture("tracker-lm/targets-nothing", &files);
    change(&case, "targets.csv", &["x_mm", "y_mm", "z_mm"], |n, old| {
        old[n.min(old.len() * 4 / 5)].clone()
    });
    let said = case.run("loop");
    let text = said.stdout + &said.stderr;
    assert!(text.contains("`x_mm`, `y_mm`, `z_mm` of targets.csv are stuck"), "{text}");
}
