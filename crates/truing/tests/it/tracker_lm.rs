//! `tracker-lm`: answers, files, and one message for every slip.

use std::fs;

use serde_json::Value;

use crate::command::{Case, truing};

const CASE: &str = include_str!("../../templates/tracker-lm/case.toml");
const STATIONS: &str = include_str!("../../templates/tracker-lm/stations.csv");
const MOUNTS: &str = include_str!("../../templates/tracker-lm/mounts.csv");
const RANGES: &str = include_str!("../../templates/tracker-lm/ranges.csv");

fn case(stations: &str, mounts: &str, ranges: &str) -> Case {
    Case::new(&[
        ("case.toml", CASE),
        ("stations.csv", stations),
        ("mounts.csv", mounts),
        ("ranges.csv", ranges),
    ])
}

/// Lines of a table that keep what `keep` says of their cells; comments and header stay.
fn lines(table: &str, keep: impl Fn(&[&str]) -> bool) -> String {
    let mut header = true;
    let wanted = |line: &&str| {
        if line.starts_with('#') || std::mem::take(&mut header) {
            return true;
        }
        keep(&line.split(',').collect::<Vec<_>>())
    };
    table.lines().filter(wanted).map(|line| format!("{line}\n")).collect()
}

fn refused(case: &Case, code: i32) -> String {
    let ended = truing(&["solve", case.path().to_str().unwrap()]);
    assert_eq!(ended.code, code, "{}", ended.stderr);
    assert_eq!(ended.stdout, "");
    ended.one_message()
}

#[test]
fn the_answer_has_the_keys_of_the_contract() {
    let case = case(STATIONS, MOUNTS, RANGES);
    let ended = truing(&["solve", case.path().to_str().unwrap(), "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let answer: Value = serde_json::from_str(&ended.stdout).unwrap();
    let estimates = &answer["estimates"];
    assert_eq!(estimates["stations"].as_array().unwrap().len(), 5);
    assert!(estimates["stations"][0]["std_mm"].as_f64().unwrap() < 0.004);
    let errors = estimates["axis_errors"].as_array().unwrap();
    assert_eq!(estimates["points"], 3 * errors.len());
    assert_eq!(errors[0]["angle_deg"], -90.0);
    for name in ["e_x_mm", "e_y_mm", "e_z_mm", "e_a_rad", "e_b_rad", "e_c_rad"] {
        assert_eq!(errors[0][name], 0.0, "{name} is relative to the first angle");
        assert!(errors[1][format!("std_{name}")].as_f64().unwrap() > 0.0);
    }
    assert_eq!(answer["residual"]["n"], 15 * errors.len());
    // What is hidden in the example is in the residual, until the loop finds it.
    assert!(answer["residual"]["rms"].as_f64().unwrap() > 0.001);
    assert!(case.json("loop")["residual"]["rms"].as_f64().unwrap() < 0.001);
}

/// A place on the grid of a land survey, mm.
const GRID_MM: [f64; 3] = [4_157_870_237.0, 671_429_132.0, -774_958_256.0];

/// Half of the last digit that a double has for such a number, and as much again for a sum.
const GRID_DIGIT_MM: f64 = 1e-6;

#[test]
fn an_axis_on_the_grid_of_a_land_survey_is_calibrated_as_one_at_the_zero() {
    let near = case(STATIONS, MOUNTS, RANGES).json("solve");
    let mut header = true;
    let moved = STATIONS.lines().map(|line| {
        if line.starts_with('#') || std::mem::take(&mut header) {
            return format!("{line}\n");
        }
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        for (cell, by) in cells[1..4].iter_mut().zip(GRID_MM) {
            *cell = (cell.parse::<f64>().unwrap() + by).to_string();
        }
        cells.join(",") + "\n"
    });
    let far = case(&moved.collect::<String>(), MOUNTS, RANGES);
    let origin = [418.899, 409.057, 767.388];
    let moved: Vec<String> =
        origin.iter().zip(GRID_MM).map(|(v, by)| format!("{:.6}", v + by)).collect();
    far.replace("case.toml", "[418.899, 409.057, 767.388]", &format!("[{}]", moved.join(", ")));
    let far = far.json("solve");
    let (near, far) = (&near["estimates"], &far["estimates"]);
    let number = |value: &Value| value.as_f64().unwrap();
    for (k, error) in near["axis_errors"].as_array().unwrap().iter().enumerate() {
        for name in ["e_x_mm", "e_y_mm", "e_z_mm"] {
            let off = number(&far["axis_errors"][k][name]) - number(&error[name]);
            assert!(off.abs() < 10.0 * GRID_DIGIT_MM, "{name} at {k}: {off}");
        }
    }
    for (k, station) in near["stations"].as_array().unwrap().iter().enumerate() {
        for (name, by) in ["x_mm", "y_mm", "z_mm"].iter().zip(GRID_MM) {
            let off = number(&far["stations"][k][name]) - by - number(&station[name]);
            assert!(off.abs() < 10.0 * GRID_DIGIT_MM, "{name} of station {k}: {off}");
        }
    }
}

#[test]
fn files_are_written_beside_the_answer() {
    let case = case(STATIONS, MOUNTS, RANGES);
    let at = |name: &str| case.file(name).to_str().unwrap().to_owned();
    let (csv, comp, tab, page) = (at("b.csv"), at("b.comp"), at("b.tab"), at("b.html"));
    let ended = truing(&[
        "solve",
        case.path().to_str().unwrap(),
        "--errors",
        &csv,
        "--compensation",
        &comp,
        "--heidenhain",
        &tab,
        "--report",
        &page,
    ]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(fs::read_to_string(csv).unwrap().starts_with("angle_deg,EXB_mm,"));
    assert!(
        fs::read_to_string(comp)
            .unwrap()
            .starts_with("-90.000000000 -90.000000000 -90.000000000\n")
    );
    let tab = fs::read_to_string(tab).unwrap();
    assert!(tab.starts_with("; ") && tab.contains("\nBEGIN ERRORS_B.TAB MM\n"), "{tab}");
    let page = fs::read_to_string(page).unwrap();
    assert!(page.contains("Rotation errors of axis B") && page.contains("ECB"));
}

#[test]
fn other_kinds_have_no_such_files() {
    let case = Case::new(&[]);
    let folder = case.file("frame");
    let folder = folder.to_str().unwrap();
    assert_eq!(truing(&["init", "frame-fit", folder]).code, 0);
    let ended = truing(&["solve", folder, "--errors", case.file("x.csv").to_str().unwrap()]);
    assert_eq!(ended.code, 2);
    assert!(ended.one_message().contains("`frame-fit` has no such file"));
}

#[test]
fn too_little_is_not_determined() {
    let three = case(
        &lines(STATIONS, |c| matches!(c[0], "S1" | "S2" | "S3")),
        MOUNTS,
        &lines(RANGES, |c| matches!(c[0], "S1" | "S2" | "S3")),
    );
    assert!(refused(&three, 3).contains("3 stations"));
    let two = case(STATIONS, &lines(MOUNTS, |c| c[0] != "R3"), &lines(RANGES, |c| c[1] != "R3"));
    assert!(refused(&two, 3).contains("2 reflectors"));
    let line = "mount,x_mm,y_mm,z_mm\nR1,0,-60,-150\nR2,10,0,-100\nR3,20,60,-50\n";
    assert!(refused(&case(STATIONS, line, RANGES), 3).contains("one line"));
}

#[test]
fn slips_are_named_with_their_line() {
    let first = RANGES.lines().find(|line| line.starts_with("S1,R1,")).unwrap();
    let twice = format!("{RANGES}{first}\n");
    let n = twice.lines().count();
    let message = refused(&case(STATIONS, MOUNTS, &twice), 2);
    assert!(
        message.contains(&format!("ranges.csv, line {n}: station S1 has two readings")),
        "{message}"
    );

    let unknown = format!("{RANGES}{}\n", first.replacen("S1", "S9", 1));
    let message = refused(&case(STATIONS, MOUNTS, &unknown), 2);
    assert!(message.contains("station `S9` is not in stations.csv"), "{message}");

    let message = refused(&case(STATIONS, MOUNTS, &lines(RANGES, |c| c[0] != "S4")), 2);
    assert!(message.contains("station `S4` has no rows in ranges.csv"), "{message}");

    let other_angle = format!("{RANGES}{}\n", "S1,R1,1,12.5,100.0,0");
    let message = refused(&case(STATIONS, MOUNTS, &other_angle), 2);
    assert!(message.contains("step `1` has `-90` and `12.5` in column `angle_deg`"), "{message}");
}

/// Tables written by a loop are those with what it accepted: the numbers of its own JSON.
#[test]
fn files_of_a_loop_hold_what_it_accepted() {
    let folder = format!("{}/../../fixtures/tracker-lm/dead-path-jump", env!("CARGO_MANIFEST_DIR"));
    let read = |file: &str| fs::read_to_string(format!("{folder}/{file}")).unwrap();
    let texts = ["case.toml", "stations.csv", "mounts.csv", "ranges.csv"].map(|f| (f, read(f)));
    let case = Case::new(&texts.each_ref().map(|(file, text)| (*file, text.as_str())));
    let files = ["errors.csv", "axis.comp", "axis.tab"].map(|name| case.file(name));
    let [csv, comp, tab] = files.each_ref().map(|path| path.to_str().unwrap());
    let words = ["loop", case.path().to_str().unwrap(), "--json", "--errors", csv];
    let ended = truing(&[&words[..], &["--compensation", comp, "--heidenhain", tab]].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let answer: Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!(answer["steps"][0]["effect"], "dead-path-jump");
    let solved = case.json("solve");
    let rows = |path: &str| -> Vec<Vec<f64>> {
        let text = fs::read_to_string(path).unwrap();
        let numbers = |line: &str| -> Option<Vec<f64>> {
            line.split([',', ' ']).filter(|cell| !cell.is_empty()).map(|v| v.parse().ok()).collect()
        };
        text.lines().filter_map(numbers).collect()
    };
    let (errors, table, triplets) = (rows(csv), rows(tab), rows(comp));
    let names = ["e_x_mm", "e_y_mm", "e_z_mm", "e_a_rad", "e_b_rad", "e_c_rad"];
    let mut moved = 0.0_f64;
    for (k, printed) in answer["estimates"]["axis_errors"].as_array().unwrap().iter().enumerate() {
        let angle_deg = printed["angle_deg"].as_f64().unwrap();
        for (c, name) in names.iter().enumerate() {
            let value = printed[name].as_f64().unwrap();
            // Seven digits are written, and six decimals of the table.
            assert!((errors[k][1 + c] - value).abs() <= 1e-6 * value.abs(), "{name} at {k}");
            let in_table = if c < 3 { value } else { value.to_degrees() };
            assert!((table[k][2 + c] - in_table).abs() <= 0.51e-6, "{name} at {k}");
            let before = solved["estimates"]["axis_errors"][k][name].as_f64().unwrap();
            moved = moved.max((value - before).abs());
        }
        let own = printed["e_b_rad"].as_f64().unwrap().to_degrees();
        assert!((triplets[k][1] - angle_deg - own).abs() <= 0.51e-6, "{:?}", triplets[k]);
    }
    assert!(moved > 1e-4, "a jump of 6 µm moves errors by more than {moved:e}");
}
