//! Mistakes in wrenches of a force/torque sensor.

use std::cmp::Ordering;

use serde_json::Value;

use super::{change, first, fixture, scale};
use crate::command::Case;

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

/// Both in units a thousand times as large: what is left goes with nothing.
#[test]
fn noise_of_forces_and_moments_in_another_unit_is_named() {
    let case = fixture("ft-center/nothing-coloured", &["case.toml", "presses.csv", "wrench.csv"]);
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    case.write("case.toml", text + "\n[noise]\nforce_n = 5e-5\nmoment_nmm = 2.5e-3\n");
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:unit", "{step}");
    let said = step["description"].as_str().unwrap();
    assert!(said.contains("force_n") && said.contains("moment_nmm"), "{said}");
}

/// To presses that is what two axes exchanged are, or one of the other sign.
#[test]
fn a_wrong_handedness_is_among_what_is_named() {
    let case = fixture("ft-center/nothing-coloured", &["case.toml", "presses.csv", "wrench.csv"]);
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    let of = |name: &str| format!("{text}\n[model]\nhandedness = \"{name}\"\n");
    case.write("case.toml", of("same"));
    let is_wrong = case.json("loop")["verdict"] == "input-wrong";
    let (right, wrong) = if is_wrong { ("opposed", "same") } else { ("same", "opposed") };
    case.write("case.toml", of(right));
    assert_ne!(case.json("loop")["verdict"], "input-wrong");
    case.write("case.toml", of(wrong));
    let rivals = first(&case).0["indistinguishable_from"].to_string();
    assert!(rivals.contains("input:handedness"), "{rivals}");
}

const NOISE_TOO_SMALL: &str = "\n[noise]\nforce_n = 0.001\nmoment_nmm = 0.05\n";

#[test]
fn a_case_that_cannot_be_fitted_says_why() {
    let case = fixture("ft-center/nothing-coloured", &["case.toml", "presses.csv", "wrench.csv"]);
    scale(&case, "wrench.csv", &["mx_nmm", "my_nmm", "mz_nmm"], 1e-3);
    let said = case.run("loop");
    assert!(
        format!("{}{}", said.stdout, said.stderr).contains("N·m instead of N·mm"),
        "{}",
        said.stderr
    );
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

/// Declared is the noise of the records; the seats scatter beyond it.
#[test]
fn some_presses_in_another_unit_are_found_however_the_seats_scatter() {
    let case = fixture("ft-center/nothing-coloured", &["case.toml", "presses.csv", "wrench.csv"]);
    let text = std::fs::read_to_string(case.file("case.toml")).unwrap();
    case.write("case.toml", text + NOISE_TOO_SMALL);
    change(&case, "presses.csv", &["machine_x_mm", "machine_y_mm"], |n, old| {
        let inches = |cell: &String| cell.parse::<f64>().unwrap() / 25.4;
        let is_wrong = (old.len() / 3..2 * old.len() / 3).contains(&n);
        old[n]
            .iter()
            .map(|cell| if is_wrong { inches(cell).to_string() } else { cell.clone() })
            .collect()
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:unit", "{step}");
}

/// A cell that was put in moves all below it: two thirds of the presses are wrong.
#[test]
fn positions_that_are_shifted_from_some_row_to_the_end_are_shifted_back() {
    let case = fixture("ft-center/nothing-coloured", &["case.toml", "presses.csv", "wrench.csv"]);
    change(&case, "presses.csv", &["machine_x_mm"], |n, old| {
        let from = match n.cmp(&(old.len() / 3)) {
            Ordering::Less => n,
            Ordering::Equal => old.len() - 1,
            Ordering::Greater => n - 1,
        };
        old[from].clone()
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:row-shift", "{step}");
    assert!(step["description"].as_str().unwrap().contains("from line 10"), "{step}");
}

/// Twenty-four rows of point, commanded and solved displacement.
fn displacements(row: impl Fn(i32) -> String) -> Case {
    let table: String = (0..24).map(row).collect();
    Case::new(&[
        ("case.toml", "kind = \"ft-center\"\n[noise]\ndisplacement_mm = 0.003\n"),
        ("displacements.csv", &format!("point,commanded_mm,solved_mm\n{table}")),
    ])
}

#[test]
fn commanded_displacements_as_differences_are_added_up() {
    let row = |n: i32| {
        let at = f64::from(n * n) / 10.0 + f64::from(n);
        let noise = 0.004 * (1e5 * (12.9898 * f64::from(n)).sin()).fract();
        let before = f64::from((n - 1).pow(2)) / 10.0 + f64::from(n - 1);
        let step = if n == 0 { at } else { at - before };
        format!("p{n},{step:.2},{:.4}\n", at + noise)
    };
    let (step, answer) = first(&displacements(row));
    assert_eq!(step["effect"], "input:increments", "{step}");
    assert_eq!(step["subject"], "displacements.csv: commanded_mm");
    assert_eq!(answer["steps"].as_array().unwrap().len(), 1, "{}", answer["steps"]);
}

/// A head that moved half of what its diameter programme says: no sensor reads moments too small by half.
#[test]
fn commanded_displacements_as_diameters_are_no_gain() {
    let row = |n: i32| {
        let at = f64::from(n) * 1.7 + 2.0;
        let noise = 0.004 * (1e5 * (12.9898 * f64::from(n)).sin()).fract();
        format!("p{n},{:.2},{:.4}\n", 2.0 * at, at + noise)
    };
    let (step, answer) = first(&displacements(row));
    assert_eq!(step["effect"], "input:diameter", "{step}");
    // Which of the two is the diameter, the tables do not say.
    let either = format!("{} {}", step["subject"], step["indistinguishable_from"]);
    assert!(either.contains("commanded_mm") && either.contains("solved_mm"), "{either}");
    assert_eq!(answer["steps"].as_array().unwrap().len(), 1, "{}", answer["steps"]);
}

/// Forces that are small by their unit pile up at the upper end of their range.
#[test]
fn forces_in_another_unit_from_some_press_on_do_not_clip() {
    let case = fixture("ft-center/nothing-coloured", &["case.toml", "presses.csv", "wrench.csv"]);
    change(&case, "wrench.csv", &["fx_n", "fy_n", "fz_n"], |n, old| {
        let newtons = |cell: &String| cell.parse::<f64>().unwrap();
        let in_kgf = |cell: &String| format!("{:.5}", newtons(cell) / 9.80665);
        if n < old.len() / 2 { old[n].clone() } else { old[n].iter().map(in_kgf).collect() }
    });
    let said = case.run("loop");
    let said = format!("{}{}", said.stdout, said.stderr);
    assert!(said.contains("kgf instead of N, from line"), "{said}");
}

/// A moment comes from another amplifier, six samples late: of samples during which the head moves, its mean
/// is of other forces.
#[test]
fn a_channel_that_comes_late_by_some_samples_is_shifted_back() {
    const LATE: u32 = 6;
    const SAMPLES: u32 = 40;
    let mut record = "press,time_s,fx_n,fy_n,fz_n,mx_nmm,my_nmm,mz_nmm\n".to_owned();
    let mut presses = "press,machine_x_mm,machine_y_mm,use\n".to_owned();
    for press in 0..12_u32 {
        let at = |axis: u32| 30.0 * (1.7 * f64::from(press * (axis + 2))).sin();
        presses += &format!("p{press},{:.4},{:.4},frame\n", at(0), at(1));
        let force = |n: u32| 20.0 + 10.0 * (0.2 * f64::from(n) + f64::from(press)).sin();
        for n in 0..SAMPLES {
            let noise = |k: u32| {
                0.02 * (1e4 * (12.9 * f64::from(SAMPLES * press + n + 9973 * k)).sin()).sin()
            };
            let late = force(n.saturating_sub(LATE));
            record += &format!(
                "p{press},{:.2},{:.4},{:.4},{:.4},{:.3},{:.3},{:.3}\n",
                0.01 * f64::from(n),
                noise(1),
                noise(2),
                force(n) + noise(3),
                at(1) * force(n) + noise(4),
                -at(0) * late + noise(5),
                noise(6)
            );
        }
    }
    let toml = "kind = \"ft-center\"\n[contact]\nz0_mm = 10.0\n[noise]\nforce_n = 0.014\nmoment_nmm = 0.014\n";
    let case =
        Case::new(&[("case.toml", toml), ("presses.csv", &presses), ("wrench.csv", &record)]);
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:row-shift", "{step}");
    assert_eq!(step["subject"], "wrench.csv: my_nmm");
}

/// A tool of 20 N, its centre of gravity 50 mm along z, in 24 orientations of a base whose z points up.
fn still_poses() -> String {
    let mut table = "pose,qw,qx,qy,qz,fx_n,fy_n,fz_n,mx_nmm,my_nmm,mz_nmm\n".to_owned();
    for i in 0..24 {
        let n = f64::from(i);
        // About x and then about the turned z.
        let ((s, c), (t, d)) = ((0.35 * n).sin_cos(), (0.8 * n).sin_cos());
        let [qw, qx, qy, qz] = [c * d, s * d, -s * t, c * t];
        // Down in the sensor's axes: the third row of its rotation, negative.
        let down = [
            -2.0 * (qx * qz - qw * qy),
            -2.0 * (qy * qz + qw * qx),
            2.0 * (qx * qx + qy * qy) - 1.0,
        ];
        let noise = |k: i32| (43_758.545 * (12.9898 * n + 78.233 * f64::from(k)).sin()).fract();
        let [fx, fy, fz] = down.map(|d| 20.0 * d);
        let moment = [-50.0 * fy, 50.0 * fx, 0.0];
        let read = [fx, fy, fz].into_iter().chain(moment);
        let sizes = [0.05, 0.05, 0.05, 2.0, 2.0, 2.0];
        let read: Vec<String> = (read.zip(sizes).zip(0..))
            .map(|((value, size), k)| format!("{:.4}", value + size * noise(k)))
            .collect();
        table += &format!("g{i},{qw:.9},{qx:.9},{qy:.9},{qz:.9},{}\n", read.join(","));
    }
    table
}

/// Bases hang, and tables say so in their own axes.
#[test]
fn gravity_along_another_axis_of_the_base_is_no_tilt() {
    let declared = "kind = \"ft-center\"\n[noise]\nforce_n = 0.03\nmoment_nmm = 1.2\n";
    let case = Case::new(&[("case.toml", declared), ("gravity.csv", &still_poses())]);
    let sound = case.json("loop");
    assert_eq!(sound["verdict"], "nothing-missing", "{}", sound["steps"]);
    case.write("case.toml", format!("{declared}[model]\ngravity = [0.0, -1.0, 0.0]\n"));
    let (step, _) = first(&case);
    assert_eq!(
        (&step["effect"], &step["subject"]),
        (&"input:direction".into(), &"case.toml: [model] gravity".into()),
        "{step}"
    );
}

/// Two presses with the record of a third would be two bad presses.
#[test]
fn records_that_are_those_of_another_press_are_named_with_it() {
    let case = fixture("ft-center/nothing-coloured", &["case.toml", "presses.csv", "wrench.csv"]);
    let text = std::fs::read_to_string(case.file("wrench.csv")).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header = lines.next().unwrap();
    let mut presses: Vec<(String, Vec<&str>)> = Vec::new();
    for line in lines {
        let name = line.split(',').next().unwrap();
        match presses.last_mut() {
            Some((last, rows)) if last == name => rows.push(line),
            _ => presses.push((name.to_owned(), vec![line])),
        }
    }
    let columns: Vec<&str> = header.split(',').collect();
    let is_read = |name: &str| name.ends_with("_n") || name.ends_with("_nmm");
    let first_read = columns.iter().position(|name| is_read(name)).unwrap();
    assert!(columns[first_read..].iter().all(|name| is_read(name)), "{header}");
    let original = presses[3].clone();
    let mut all = header.to_owned() + "\n";
    for (at, (_, rows)) in presses.iter().enumerate() {
        for (n, row) in rows.iter().enumerate() {
            let source = if at == 7 || at == 8 { original.1[n % original.1.len()] } else { row };
            let own: Vec<&str> = row.split(',').collect();
            let read: Vec<&str> = source.split(',').collect();
            all += &[&own[..first_read], &read[first_read..]].concat().join(",");
            all += "\n";
        }
    }
    case.write("wrench.csv", all);
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:copied", "{step}");
    let said = step["description"].as_str().unwrap();
    let expected = format!("is {}, {} repeat those of {}", presses[7].0, presses[8].0, original.0);
    assert!(said.contains(&expected), "{said}");
}
