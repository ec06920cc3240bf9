//! What can be wrong with a log of a polishing head, what is said without a reference, and the
//! design card.

use std::fs;

use crate::command::{Case, truing};

fn message(case: &Case, code: i32) -> String {
    case.message("solve", code).replace(&format!("{}/", case.path().display()), "")
}

fn edited(file: &str, from: &str, to: &str) -> Case {
    let case = Case::example("force-impedance");
    case.replace(file, from, to);
    case
}

/// The example with one cell of the third sample changed.
fn with_cell(column: &str, to: &str) -> (Case, usize) {
    let case = Case::example("force-impedance");
    let text = fs::read_to_string(case.file("log.csv")).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let header = lines.iter().position(|l| l.starts_with("time_s")).unwrap();
    let at = lines[header].split(',').position(|name| name == column).unwrap();
    let mut cells: Vec<&str> = lines[header + 3].split(',').collect();
    cells[at] = to;
    lines[header + 3] = cells.join(",");
    case.write("log.csv", lines.join("\n") + "\n");
    (case, header + 4)
}

/// The example without a column.
fn without(column: &str) -> Case {
    let case = Case::example("force-impedance");
    let text = fs::read_to_string(case.file("log.csv")).unwrap();
    let lines: Vec<&str> = text.lines().filter(|l| !l.starts_with('#')).collect();
    let at = lines[0].split(',').position(|name| name == column).unwrap();
    let kept = |line: &&str| -> String {
        let cells = line.split(',').enumerate().filter(|(i, _)| *i != at);
        cells.map(|(_, cell)| cell).collect::<Vec<_>>().join(",")
    };
    let rows: Vec<String> = lines.iter().map(kept).collect();
    case.write("log.csv", rows.join("\n") + "\n");
    case
}

#[test]
fn samples_that_cannot_be() {
    let (case, line) = with_cell("ny", "0.5");
    assert!(message(&case, 2).contains(&format!("log.csv, line {line}: (nx, ny, nz) has length")));
    let (case, line) = with_cell("l2_mm", "7.0");
    assert!(message(&case, 2).contains(&format!("log.csv, line {line}: sample 3: ")));
    let (case, line) = with_cell("time_s", "0.0");
    assert!(message(&case, 2).contains(&format!("log.csv, line {line}: time does not increase")));
    let (case, line) = with_cell("f3_n", "NaN");
    assert!(message(&case, 2).contains(&format!("log.csv, line {line}, column 8")));
}

#[test]
fn heads_that_cannot_be() {
    let same = edited("case.toml", "bracket_radius_mm = 110.0", "bracket_radius_mm = 40.0");
    assert!(message(&same, 2).contains("bracket_radius_mm − head_radius_mm is 0"));
    let line = edited("case.toml", "[90.0, 210.0, 330.0]", "[0.0, 180.0, 0.0]");
    assert!(message(&line, 3).contains("leave a tilt of the head free"));
    let heavy = edited("case.toml", "center_of_gravity_mm = 140.0\n", "");
    assert!(message(&heavy, 2).contains("center_of_gravity_mm"));
    let nowhere = edited("case.toml", "gravity = [0.0, 0.0, -1.0]", "gravity = [0.0, 0.0, 0.0]");
    assert!(message(&nowhere, 2).contains("must not be the zero vector"));
}

#[test]
fn without_a_reference_the_answer_says_what_cannot_be_seen() {
    let case = without("reference_n");
    let solved = case.json("solve");
    assert!(solved["estimates"]["contact_force"]["rms_error_n"].is_null());
    assert_eq!(solved["residual"]["unit"], "mm");
    let said = solved["warnings"].to_string();
    assert!(said.contains("no column `reference_n`"), "{said}");
    let closed = case.json("loop");
    assert_eq!(closed["verdict"], "nothing-missing");
    let unseen = closed["not_observable"].to_string();
    assert!(unseen.contains("head-weight") && unseen.contains("spline-friction"), "{unseen}");
    assert!(unseen.contains("reference instrument"), "{unseen}");
}

#[test]
fn the_report_shows_force_and_correction() {
    let case = Case::example("force-impedance");
    let page = case.file("report.html");
    let path = case.path().to_str().unwrap();
    for command in ["solve", "loop"] {
        let ended = truing(&[command, path, "--report", page.to_str().unwrap()]);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        let text = fs::read_to_string(&page).unwrap();
        assert!(text.contains("Contact force") && text.contains("Correction"), "{command}");
    }
}

#[test]
fn a_design_card_is_printed_and_refused() {
    let card = truing(&["design", "force", "--delay", "0.002", "--lag", "0.005", "--json"]);
    assert_eq!(card.code, 0, "{}", card.stderr);
    let card: serde_json::Value = serde_json::from_str(&card.stdout).unwrap();
    assert_eq!(card["recommended"], true);
    let contacts = card["contacts"].as_array().unwrap();
    assert!(contacts.iter().all(|c| c["stable"] == true), "{contacts:?}");
    let given = ["design", "force", "--mass", "1", "--damping", "0.5", "--stiffness", "50"];
    let text = truing(&[&given[..], &["--absolute"]].concat());
    assert!(text.stdout.contains("impedance, given: M = 1.0000 kg"), "{}", text.stdout);
    assert!(text.stdout.contains(" NO "), "{}", text.stdout);
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("card.html");
    let drawn = truing(&[&given[..], &["--report", page.to_str().unwrap()]].concat());
    assert_eq!(drawn.code, 0, "{}", drawn.stderr);
    let page = fs::read_to_string(page).unwrap();
    for needed in [
        "Stable region",
        "region comfortable",
        "region stable",
        "1.000 kg",
        "<td class=\"unit\">no",
    ] {
        assert!(page.contains(needed), "{needed}");
    }
    let refused = truing(&["design", "force", "--interval", "0"]);
    assert_eq!(refused.code, 2);
    assert_eq!(refused.one_message(), "interval_s is 0, must be positive and finite");
}
