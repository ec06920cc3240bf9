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
