//! Both rotary axes of a head in one case: answers, files and messages.

use std::fs;

use crate::command::{Case, truing};

const CASE: &str = include_str!("../../../../fixtures/tracker-lm/both-axes/case.toml");
const STATIONS: &str = include_str!("../../../../fixtures/tracker-lm/both-axes/stations.csv");
const MOUNTS: &str = include_str!("../../../../fixtures/tracker-lm/both-axes/mounts.csv");
const RANGES: &str = include_str!("../../../../fixtures/tracker-lm/both-axes/ranges.csv");

fn case(ranges: &str) -> Case {
    Case::new(&[
        ("case.toml", CASE),
        ("stations.csv", STATIONS),
        ("mounts.csv", MOUNTS),
        ("ranges.csv", ranges),
    ])
}

/// Lines of the table whose angles of both axes are wanted.
fn rows(keep: impl Fn(&str, &str) -> bool) -> String {
    let is_wanted = |(i, line): &(usize, &str)| {
        let cells: Vec<&str> = line.split(',').collect();
        *i == 0 || keep(cells[3], cells[4])
    };
    let lines = RANGES.lines().enumerate().filter(is_wanted);
    lines.map(|(_, line)| format!("{line}\n")).collect()
}

#[test]
fn both_axes_and_their_relation_are_answered() {
    let case = case(RANGES);
    let answer = case.json("solve");
    let estimates = &answer["estimates"];
    assert_eq!(estimates["axis"]["letter"], "C");
    assert_eq!(estimates["axis_errors"].as_array().unwrap().len(), 13);
    let second = &estimates["second_axis"];
    assert_eq!(second["axis"]["letter"], "B");
    let errors = second["axis_errors"].as_array().unwrap();
    assert_eq!(errors.len(), 11);
    assert_eq!(errors[0]["angle_deg"], 5.0);
    assert_eq!(errors[0]["e_x_mm"], 0.0);
    assert_eq!(second["axis_location"]["names"][3], "EC0B");
    let relation = &estimates["axes_relation"];
    assert_eq!(relation["nominal_offset_mm"], 30.0);
    assert_eq!(relation["nominal_angle_deg"], 90.0);
    // Known without the frame of the stations, which both places carry.
    let std = |of: &serde_json::Value| of.as_f64().unwrap();
    let of_places =
        std(&estimates["axis_location"]["std"][2]).hypot(std(&second["axis_location"]["std"][2]));
    assert!(std(&relation["std_rotation_rad"]) < 0.5 * of_places);

    let text = case.run("solve").stdout;
    for words in [
        "errors of axis C",
        "errors of axis B",
        "offset of B from C along x",
        "squareness of B to C",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

#[test]
fn every_axis_has_files_and_pictures_of_its_own() {
    let case = case(RANGES);
    let file = |name: &str| case.file(name).to_str().unwrap().to_owned();
    let ended = truing(&[
        "solve",
        case.path().to_str().unwrap(),
        "--errors",
        &file("head.csv"),
        "--compensation",
        &file("head.comp"),
        "--report",
        &file("head.html"),
    ]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let read = |name: &str| fs::read_to_string(case.file(name)).unwrap();
    assert!(read("head.csv").starts_with("angle_deg,EXC_mm"));
    assert!(read("head-B.csv").starts_with("angle_deg,EXB_mm"));
    assert_eq!((read("head.comp").lines().count(), read("head-B.comp").lines().count()), (13, 11));
    let page = read("head.html");
    for title in ["Displacement errors of axis C", "Rotation errors of axis B"] {
        assert!(page.contains(title), "{title}");
    }
}

#[test]
fn what_two_axes_need_is_said() {
    let message = case(&rows(|_, b| b == "5")).message("solve", 3);
    assert!(message.contains("axis B stands at 5.0000° at every step"), "{message}");
    let message = case(&rows(|c, b| c != "0" || b != "5")).message("solve", 3);
    assert!(
        message.contains("no step at 0.0000° of the first and 5.0000° of the second"),
        "{message}"
    );

    let column = case(&RANGES.replace("second_angle_deg", "other_deg")).message("solve", 2);
    assert!(column.contains("second_angle_deg"), "{column}");
    let sound = case(RANGES);
    sound.replace("case.toml", "letter = \"B\"", "letter = \"C\"");
    let same = sound.message("solve", 2);
    assert!(same.contains("two axes of a head have two letters"), "{same}");
    let sound = case(RANGES);
    sound.replace("case.toml", "[noise]", "[model]\naxis = \"fixed\"\n\n[noise]");
    let fixed = sound.message("solve", 2);
    assert!(
        fixed.contains("both axes of a head are calibrated in the joint formulation"),
        "{fixed}"
    );
    // One step with two angles of the second axis.
    let two = case(&RANGES.replacen(",0,105,", ",0,104,", 1)).message("solve", 2);
    assert!(two.contains("second_angle_deg"), "{two}");
}
