//! `tracker-lm` on points: answers and messages.

use std::fmt::Write;

use serde_json::Value;

use crate::command::{Case, truing};

const CASE: &str = "kind = \"tracker-lm\"\n[axis]\nletter = \"C\"\norigin_mm = [0, 0, 0]\n\
    [noise]\nrange_mm = 0.01\nangle_rad = 5e-6\n";
const STATIONS: &str = "station,x_mm,y_mm,z_mm\ntracker,3000,0,0\n";
const MOUNTS: [(&str, [f64; 3]); 4] = [
    ("a", [800.0, 0.0, 100.0]),
    ("b", [-500.0, 700.0, -50.0]),
    ("c", [-400.0, -600.0, 200.0]),
    ("d", [300.0, 500.0, -200.0]),
];
/// Turn short of every stop after the first.
const SHORT_RAD: f64 = 40e-6;

fn mounts(column: &str, of: impl Fn(&str) -> String) -> String {
    let mut table = format!("mount,x_mm,y_mm,z_mm{column}\n");
    for (name, [x, y, z]) in MOUNTS {
        writeln!(table, "{name},{x},{y},{z}{}", of(name)).unwrap();
    }
    table
}

/// Stops of 15°, seen from 3 m along x, looking back.
fn targets(stops: i32) -> String {
    let mut table = "station,mount,step,angle_deg,x_mm,y_mm,z_mm\n".to_owned();
    for step in 0..stops {
        let angle_deg = 15.0 * f64::from(step);
        let turned = angle_deg.to_radians() - if step == 0 { 0.0 } else { SHORT_RAD };
        let (sin, cos) = turned.sin_cos();
        for (n, (name, [x, y, z])) in MOUNTS.iter().enumerate() {
            // Ten micrometres of repeatable «noise».
            let k = f64::from(step * 4 + i32::try_from(n).unwrap());
            let off = 0.014 * (2.4 * k * k).sin();
            let (x, y) = (cos * x - sin * y, sin * x + cos * y);
            let across = 0.014 * (1.1 * k * k).cos();
            let (x, y, z) = (3000.0 - x, across - y, z + off);
            writeln!(table, "tracker,{name},{step},{angle_deg},{x:.5},{y:.5},{z:.5}").unwrap();
        }
    }
    table
}

fn case(settings: &str, more: &[(&str, &str)]) -> Case {
    let (mounts, targets) = (mounts("", |_| String::new()), targets(7));
    let mut files = vec![
        ("case.toml", settings),
        ("stations.csv", STATIONS),
        ("mounts.csv", mounts.as_str()),
        ("targets.csv", targets.as_str()),
    ];
    files.retain(|(name, _)| !more.iter().any(|(other, _)| other == name));
    files.extend_from_slice(more);
    Case::new(&files)
}

fn answer(command: &str, case: &Case) -> Value {
    let ended = truing(&[command, case.path().to_str().unwrap(), "--json"]);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    serde_json::from_str(&ended.stdout).unwrap()
}

#[test]
fn points_give_the_same_answer_as_ranges() {
    let answer = answer("solve", &case(CASE, &[]));
    let estimates = &answer["estimates"];
    assert!((estimates["stations"][0]["x_mm"].as_f64().unwrap() - 3000.0).abs() < 0.05);
    assert_eq!(estimates["points"], 28);
    let errors = estimates["axis_errors"].as_array().unwrap();
    assert_eq!(errors.len(), 7);
    assert_eq!(errors[0]["e_c_rad"], 0.0);
    for error in &errors[1..] {
        let (value, std) =
            (error["e_c_rad"].as_f64().unwrap(), error["std_e_c_rad"].as_f64().unwrap());
        assert!((value + SHORT_RAD).abs() < 20e-6 && std > 1e-6 && std < 5e-5, "{error}");
    }
    assert_eq!(answer["residual"]["n"], 84);
    assert_eq!(answer["residual"]["unit"], "mm");
}

#[test]
fn reflectors_or_steps_are_held_out() {
    // A step's six errors are taken from itself: what is left is the noise, some 10 µm.
    let steps = answer("loop", &case(CASE, &[]));
    let seen = steps["before"]["held_out_rms"].as_f64().unwrap();
    assert!((0.002..0.03).contains(&seen), "{seen}");
    let by_mount = format!("{CASE}[loop]\ngroup = \"mount\"\n");
    let body = mounts(",body", |name| if name < "c" { ",one" } else { ",two" }.to_owned());
    let mounts = answer("loop", &case(&by_mount, &[("mounts.csv", &body)]));
    // Predicted from the first stop and what three others say of the motion: some 10 µm on either.
    let seen = mounts["before"]["held_out_rms"].as_f64().unwrap();
    assert!((0.002..0.05).contains(&seen), "{seen}");
}

#[test]
fn what_says_where_a_tracker_stands_is_not_left_out() {
    // The first angle is met once: without its stop, nothing says where the one tracker stands.
    let many = targets(13);
    let steps = answer("loop", &case(CASE, &[("targets.csv", &many)]));
    assert_eq!(steps["before"]["hold_out"], "nested");
    let seen = steps["before"]["held_out_rms"].as_f64().unwrap();
    assert!((0.002..0.03).contains(&seen), "{seen}");
}

#[test]
fn slips_are_named() {
    let refused = |case: &Case| {
        let ended = truing(&["solve", case.path().to_str().unwrap()]);
        assert_eq!(ended.code, 2, "{}", ended.stderr);
        ended.one_message()
    };
    let half = CASE.replace("angle_rad = 5e-6\n", "");
    assert!(refused(&case(&half, &[])).contains("angle_rad"));
    let both = case(CASE, &[("ranges.csv", "station\n")]);
    assert!(refused(&both).contains("exclude each other"));
    let unknown = targets(7).replace("tracker,a,0,", "traker,a,0,");
    assert!(refused(&case(CASE, &[("targets.csv", &unknown)])).contains("`tracker`"));
}

#[test]
fn the_example_of_points_solves_as_it_is() {
    let case = Case::example("tracker-lm-targets");
    let solved = case.json("solve");
    assert_eq!(solved["kind"], "tracker-lm");
    assert_eq!(solved["estimates"]["axis_errors"].as_array().unwrap().len(), 13);
    assert_eq!(case.json("check")["kind"], "tracker-lm");
    let closed = case.json("loop");
    assert_eq!(closed["steps"].as_array().unwrap().len(), 1);
    // χ² per degree of freedom scatters by √(2/300) = 0.08 about one.
    let chi2 = closed["residual"]["chi2_per_dof"].as_f64().unwrap();
    assert!((chi2 - 1.0).abs() < 5.0 * 0.08, "{chi2}");
}
