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
        // One number per observation has no component to name.
        assert!(!text.contains(">, N<") && !text.contains("Residual, ,"), "{command}");
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
    assert!(refused.stderr.contains("expected a positive number"), "{}", refused.stderr);
}

/// Six runs of forty readings over 200 mm at 20 and 40 N, with 3 N too much around 100 mm in each.
fn along_a_path() -> String {
    let mut text = "run,time_s,path_mm,force_n,reference_n\n".to_owned();
    for run in 0..6_u32 {
        let asked_n = 20.0 + 20.0 * f64::from(run % 2);
        for i in 0..40_u32 {
            let path_mm = 5.0 * f64::from(i);
            let wobble_n = 0.3 * f64::from((i * 7 + run * 13) % 11) - 1.5;
            let bump_n = if (90.0..115.0).contains(&path_mm) { 3.0 } else { 0.0 };
            text += &format!("r{run},{i},{path_mm},{},{asked_n}\n", asked_n + wobble_n + bump_n);
        }
    }
    text
}

#[test]
fn runs_along_a_path_need_no_head() {
    let text = along_a_path();
    let case = Case::new(&[("case.toml", "kind = \"force-impedance\"\n"), ("path.csv", &text)]);
    let folder = case.path().to_str().unwrap();
    let solved: serde_json::Value =
        serde_json::from_str(&truing(&["solve", folder, "--json"]).stdout).unwrap();
    let estimates = &solved["estimates"];
    assert_eq!(estimates["samples"], 240);
    assert_eq!(estimates["samples_left_out"], 0);
    assert_eq!(estimates["path"].as_array().unwrap().len(), 40);
    // Wobble: 0, 0.3 … 3.0 less 1.5, each as often: rms √(10·0.09) = 0.95; 30 of 240 with 3 N more.
    let rms_n = estimates["contact_force"]["rms_error_n"].as_f64().unwrap();
    assert!((rms_n - (0.9_f64 + 9.0 / 8.0).sqrt()).abs() < 0.1, "{rms_n}");
    let closed: serde_json::Value =
        serde_json::from_str(&truing(&["loop", folder, "--json"]).stdout).unwrap();
    assert_eq!(closed["steps"][0]["effect"], "path-repeatable", "{closed}");
}

#[test]
fn paths_that_cannot_be() {
    let text = along_a_path();
    let path = |text: &str| {
        Case::new(&[("case.toml", "kind = \"force-impedance\"\n"), ("path.csv", text)])
    };
    let moved: String = (text.lines())
        .map(|line| match line.split(',').collect::<Vec<_>>()[..] {
            ["r3", time_s, mm, force_n, asked_n] => {
                let mm: f64 = mm.parse().unwrap();
                format!("r3,{time_s},{},{force_n},{asked_n}\n", mm + 900.0)
            }
            _ => format!("{line}\n"),
        })
        .collect();
    let said = message(&path(&moved), 2);
    assert!(said.contains("path.csv: the 6 runs have no stretch of the path in common"), "{said}");
    let said = message(&path(&text.replace("r2,7,", "r2,6,")), 2);
    assert!(said.contains("path.csv, line 89: time does not increase"), "{said}");
    let said = message(&path(&text.replacen(",35,", ",,", 1)), 2);
    assert!(said.contains("path.csv, line 9, column 3"), "{said}");
    let both = Case::example("force-impedance");
    both.write("path.csv", &text);
    assert!(message(&both, 2).contains("exclude each other"));
    let no_head = Case::example("force-impedance");
    no_head.write("case.toml", "kind = \"force-impedance\"\n");
    let said = message(&no_head, 2);
    assert!(said.contains("[head]") && said.contains("path.csv"), "{said}");
}
