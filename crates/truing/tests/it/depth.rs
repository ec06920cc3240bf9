//! `truing depth`: how deep a part presses into a polishing tool along a program.

use serde_json::Value;

use crate::command::{Case, Ended, truing};

const TOUCHED: &str = "kind = \"pose-icp\"\n[surface]\nshape = \"asphere\"\nradius_mm = 480.0\n\
    conic = -1.0\ndiameter_mm = 100.0\n[pose]\nheld = [\"x\", \"y\"]\n\
    initial = { x_mm = 10.0, y_mm = -20.0, z_mm = 5.0 }\n[probe]\ntip_radius_mm = 3.0\n\
    [noise]\npoint_mm = 0.001\n";
const TOOL: &str = "[tool]\nfilm_mm = 1.5\n";
/// Where the part lies above where the program was planned for.
const LIFT_MM: f64 = 0.05;

/// A ball's centre over the paraboloid, or the tool's lowest point, by a distance along its normal.
fn over(x: f64, y: f64, by_mm: f64) -> [f64; 3] {
    let slope = [-x / 480.0, -y / 480.0];
    let length = (1.0 + slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
    let z = (x * x + y * y) / 960.0;
    [x + by_mm * slope[0] / length, y + by_mm * slope[1] / length, z + by_mm / length]
}

/// Touches without noise of a part at (10, −20, 5 + LIFT) mm.
fn case(tool: &str) -> Case {
    let mut points = "point,x_mm,y_mm,z_mm\n".to_owned();
    for (n, [x, y]) in
        [[0.0, 0.0], [20.0, 0.0], [0.0, 20.0], [-40.0, 0.0], [0.0, -40.0], [25.0, 25.0]]
            .into_iter()
            .enumerate()
    {
        let [x, y, z] = over(x, y, 3.0);
        points += &format!("P{n},{:.7},{:.7},{:.7}\n", x + 10.0, y - 20.0, z + 5.0 + LIFT_MM);
    }
    Case::new(&[("case.toml", &format!("{TOUCHED}{tool}")), ("points.csv", &points)])
}

/// A program 1.2 mm over the part planned at (10, −20, 5), with a rapid move, one over the film and one
/// beside the part.
fn program() -> String {
    let mut text = "G21 G90\nG0 X0 Y0 Z50\n".to_owned();
    for [x, y] in [[0.0, 0.0], [15.0, 5.0], [-30.0, 20.0]] {
        let [x, y, z] = over(x, y, 1.2);
        text += &format!("G1 X{:.6} Y{:.6} Z{:.6} F300\n", x + 10.0, y - 20.0, z + 5.0);
    }
    text + "G1 Z60\nG1 X200 Y0 Z25\n"
}

fn depth(case: &Case, more: &[&str]) -> Ended {
    case.write("part.ngc", program());
    let (folder, file) = (case.path(), case.file("part.ngc"));
    let words = ["depth", folder.to_str().unwrap(), file.to_str().unwrap()];
    truing(&[&words[..], more].concat())
}

const PLANNED: [&str; 2] = ["--planned", "10,-20,5,0,0,0"];

#[test]
fn the_depth_is_the_planned_one_once_corrected_and_less_than_asked_before() {
    let ended = depth(&case(TOOL), &[&PLANNED[..], &["--json"]].concat());
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    let json: Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!((&json["points"], &json["beside_the_part"]), (&3.into(), &1.into()));
    assert_eq!(json["above_the_film"], 1);
    for at in json["depths"].as_array().unwrap() {
        // Coordinates are written to 1e-7 and 1e-6 mm.
        assert!((at["depth_mm"].as_f64().unwrap() - 0.3).abs() < 2e-6, "{at}");
        // The part stands higher, so the film is pressed in by as much more, along the normal.
        let as_written = at["as_written_mm"].as_f64().unwrap();
        assert!((as_written - 0.3 - LIFT_MM).abs() < 1e-3 * LIFT_MM + 2e-4, "{at}");
        assert!(at["std_pose_mm"].as_f64().unwrap() < 2e-3, "{at}");
        assert_eq!(at["std_mm"], at["std_pose_mm"]);
    }
    assert_eq!(json["within"]["decision"], "pass");
    assert_eq!(json["depths"][0]["line"], 3);
}

#[test]
fn every_uncertainty_counts_and_the_decision_follows() {
    let declared = "std_axis_mm = 0.004\nstd_film_mm = 0.003\nstd_tip_mm = 0.002\n\
        std_form_mm = 0.002\nremoval_exponent = 2.0\n";
    let case = case(&format!("{TOOL}{declared}"));
    let json: Value =
        serde_json::from_str(&depth(&case, &[&PLANNED[..], &["--json"]].concat()).stdout).unwrap();
    for at in json["depths"].as_array().unwrap() {
        let number = |key: &str| at[key].as_f64().unwrap();
        // A larger ball lowers the whole part by as much, but for its slopes.
        assert!((number("std_tip_mm") - 0.002).abs() < 2e-5, "{at}");
        let squares = number("std_pose_mm").powi(2) + number("std_tip_mm").powi(2) + 29e-6;
        assert!((number("std_mm") - squares.sqrt()).abs() < 1e-9, "{at}");
    }
    let largest = json["std_mm"].as_f64().unwrap();
    let removal = json["removal"]["largest_std_ratio"].as_f64().unwrap();
    assert!((removal - 2.0 * largest / 0.3).abs() < 1e-3 * removal);
    // 5.8 µm: within ± 10 µm in 91 of 100.
    assert_eq!(json["within"]["decision"], "undecided");
    let asked = depth(&self::case(&format!("{TOOL}depth_mm = 0.4\n")), &PLANNED);
    assert!(
        asked.stdout.starts_with("fail: every depth within ± 0.01 mm of 0.4 mm"),
        "{}",
        asked.stdout
    );
}

#[test]
fn what_is_missing_is_said() {
    let without = depth(&case(""), &PLANNED);
    assert_eq!(without.code, 2);
    assert!(without.stderr.contains("no `[tool]`: give it `film_mm`"), "{}", without.stderr);
    // In coordinates of the machine, read as those of the workpiece.
    let elsewhere = depth(&case(TOOL), &[]);
    assert_eq!(elsewhere.code, 2);
    assert!(elsewhere.stderr.contains("no move in feed polishes the part"), "{}", elsewhere.stderr);
    let other = Case::example("frame-fit");
    assert!(depth(&other, &[]).stderr.contains("pose-icp"));
}
