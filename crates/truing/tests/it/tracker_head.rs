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

/// `e + ω × q` of the JSON, with the arm that the file states.
fn moved(error: &serde_json::Value, arm: [f64; 3]) -> [f64; 3] {
    let of = |key: &str| error[key].as_f64().unwrap();
    let (e, w) =
        (["e_x_mm", "e_y_mm", "e_z_mm"].map(of), ["e_a_rad", "e_b_rad", "e_c_rad"].map(of));
    [
        e[0] + w[1] * arm[2] - w[2] * arm[1],
        e[1] + w[2] * arm[0] - w[0] * arm[2],
        e[2] + w[0] * arm[1] - w[1] * arm[0],
    ]
}

/// Rows of a file of displacements: 13 numbers each.
fn displacements(text: &str) -> Vec<Vec<f64>> {
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
}

#[test]
fn what_the_errors_do_to_the_tip_of_a_tool() {
    let case = case(RANGES);
    let file = |name: &str| case.file(name).to_str().unwrap().to_owned();
    let folder = case.path().to_str().unwrap().to_owned();
    let words = ["solve", &folder, "--json", "--point-errors", &file("tip.csv")];
    let ended = truing(&[&words[..], &["--point", "0,0,-250"]].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let answer: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    let estimates = &answer["estimates"];
    let of_b = &estimates["second_axis"];
    for (name, of, n) in [("tip.csv", estimates, 13), ("tip-B.csv", of_b, 11)] {
        let rows = displacements(&fs::read_to_string(case.file(name)).unwrap());
        assert_eq!(rows.len(), n);
        for row in rows {
            let errors = of["axis_errors"].as_array().unwrap();
            let at = |e: &&serde_json::Value| (e["angle_deg"].as_f64().unwrap() - row[0]).abs();
            let error = errors.iter().min_by(|a, b| at(a).total_cmp(&at(b))).unwrap();
            let expected = moved(error, [row[1], row[2], row[3]]);
            for k in 0..3 {
                // Arms to 1e-6 mm, rotations below 1 mrad.
                assert!((row[4 + k] - expected[k]).abs() < 1e-8, "{name}: {row:?} {expected:?}");
                assert!(row[7 + k] >= 0.0);
                // Exact and first order: ½ ω² q of rotations below 0.2 mrad.
                assert!((row[10 + k] - row[4 + k]).abs() < 1e-5, "{name}: {row:?}");
            }
            if name == "tip-B.csv" {
                // About y, the tip stays at 250 mm from the axis.
                let b = row[0].to_radians();
                assert!((row[1] + 250.0 * b.sin()).abs() < 2e-6, "{row:?}");
                assert!((row[3] + 250.0 * b.cos()).abs() < 2e-6, "{row:?}");
            }
        }
    }
    let alone = truing(&["solve", &folder, "--point", "0,0,-250"]);
    assert_eq!(alone.code, 2);
    let short = [&words[..], &["--point", "0,0"]].concat();
    assert!(truing(&short).stderr.contains("three lengths"));
}

#[test]
fn the_next_runs_of_a_head_turn_one_axis_each() {
    let case = case(RANGES);
    let folder = case.path().to_str().unwrap().to_owned();
    let words = ["plan", &folder, "--for", "range-scale", "--budget", "5", "--json"];
    let ended = truing(&words);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let answer: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    let planned = answer["plan"].as_array().unwrap();
    assert!((1..=5).contains(&planned.len()), "{answer}");
    // C stands where B turns, B at 5°.
    let away = |line: &&str| line.split(',').nth(4).unwrap() != "5";
    let turned = RANGES.lines().skip(1).find(away).unwrap();
    let stand: f64 = turned.split(',').nth(3).unwrap().parse().unwrap();
    for run in planned {
        let [c, b] = ["angle_deg", "second_angle_deg"].map(|k| run["cells"][k].as_f64().unwrap());
        assert!((c - stand).abs() < 1e-9 || (b - 5.0).abs() < 1e-9, "{run}");
    }
    // Angles that are declared are those offered.
    case.replace(
        "case.toml",
        "[noise]",
        "[plan]\nangles_deg = [33]\nsecond_angles_deg = [-17, 44]\n\n[noise]",
    );
    let ended = truing(&["plan", &folder, "--for", "range-scale", "--budget", "5", "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let answer: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    for run in answer["plan"].as_array().unwrap() {
        let [c, b] = ["angle_deg", "second_angle_deg"].map(|k| run["cells"][k].as_f64().unwrap());
        let is_first = (c - 33.0).abs() < 1e-9 && (b - 5.0).abs() < 1e-9;
        let is_second =
            (c - stand).abs() < 1e-9 && [-17.0, 44.0].iter().any(|a| (b - a).abs() < 1e-9);
        assert!(is_first || is_second, "{run}");
    }
}

/// An axis that only came through rising angles: what it lacks are runs from the other side, and two that
/// show whether these are another session.
#[test]
fn a_plan_from_the_other_side_repeats_the_ends_from_the_first() {
    const ONE: [&str; 4] = [
        include_str!("../../../../fixtures/tracker-lm/nothing/case.toml"),
        include_str!("../../../../fixtures/tracker-lm/nothing/stations.csv"),
        include_str!("../../../../fixtures/tracker-lm/nothing/mounts.csv"),
        include_str!("../../../../fixtures/tracker-lm/nothing/ranges.csv"),
    ];
    let rising: String = (ONE[3].lines().enumerate())
        .map(|(n, line)| format!("{line},{}\n", if n == 0 { "direction" } else { "1" }))
        .collect();
    let case = Case::new(&[
        ("case.toml", ONE[0]),
        ("stations.csv", ONE[1]),
        ("mounts.csv", ONE[2]),
        ("ranges.csv", &rising),
    ]);
    let folder = case.path().to_str().unwrap();
    let ended = truing(&["plan", folder, "--for", "backlash", "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let answer: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
    let runs: Vec<[f64; 2]> = (answer["plan"].as_array().unwrap().iter())
        .map(|run| ["angle_deg", "direction"].map(|key| run["cells"][key].as_f64().unwrap()))
        .collect();
    assert!(runs.iter().any(|[_, way]| *way < 0.0), "{runs:?}");
    for end in [-90.0, 90.0] {
        let again = |[angle, way]: &[f64; 2]| (angle - end).abs() < 1e-9 && *way > 0.0;
        assert!(runs.iter().any(again), "{runs:?}");
    }
}
